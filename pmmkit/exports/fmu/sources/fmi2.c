// The functions of FMI 2.0 for Model Exchange and Co-Simulation.
//
// The declarations say no more than the standard's interface: types are those of C.

#include <stddef.h>
#include <stdint.h>

#include "equations.h"
#include "ship.h"

#ifndef FMI2_Export
#if defined _WIN32
#define FMI2_Export __declspec(dllexport)
#elif defined __GNUC__
#define FMI2_Export __attribute__((visibility("default")))
#else
#define FMI2_Export
#endif
#endif
#ifdef FMI2_FUNCTION_PREFIX
#define JOIN(a, b) a##b
#define JOINED(a, b) JOIN(a, b)
#define NAME(name) JOINED(FMI2_FUNCTION_PREFIX, name)
#else
#define NAME(name) name
#endif
#define FUNCTION(name) FMI2_Export int NAME(name)

enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING };
enum { MODEL_EXCHANGE, CO_SIMULATION };

struct callbacks {
    void (*message)(
        void *environment, const char *name, int status, const char *category, const char *message, ...);
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *room);
    void (*step_finished)(void *environment, int status);
    void *environment;
};

struct events {
    int again, terminate, nominals, values, timed;
    double time;
};

static void say(const struct ship *ship, const char *message)
{
    const struct callbacks *callbacks = ship->callback;
    if (callbacks && callbacks->message) {
        callbacks->message(
            callbacks->environment, ship->name ? ship->name : "", ERROR, "logStatusError", "%s", message);
    }
}

// --- Instances -----------------------------------------------------------------------------------

FMI2_Export const char *NAME(fmi2GetTypesPlatform)(void) { return "default"; }
FMI2_Export const char *NAME(fmi2GetVersion)(void) { return "2.0"; }

FUNCTION(fmi2SetDebugLogging)(void *instance, int on, size_t count, const char *const categories[])
{
    (void)on, (void)count, (void)categories;
    return instance ? OK : ERROR;
}

FMI2_Export void *NAME(fmi2Instantiate)(
    const char *name, int type, const char *token, const char *resources,
    const struct callbacks *callbacks, int visible, int logging)
{
    (void)resources, (void)visible, (void)logging;
    struct ship *ship = made(name, token, callbacks, NULL);
    if (ship) {
        ship->steps_itself = type == CO_SIMULATION;
    }
    return ship;
}

FMI2_Export void NAME(fmi2FreeInstance)(void *instance) { freed(instance); }

// --- Modes ---------------------------------------------------------------------------------------

FUNCTION(fmi2SetupExperiment)(
    void *instance, int with_tolerance, double tolerance, double start, int with_stop, double stop)
{
    struct ship *ship = instance;
    (void)with_stop, (void)stop;
    if (!ship || ship->now.mode != INSTANTIATED) {
        return ERROR;
    }
    tolerate(&ship->now, with_tolerance, tolerance);
    moved(&ship->now, start);
    return OK;
}

FUNCTION(fmi2EnterInitializationMode)(void *instance)
{
    struct ship *ship = instance;
    if (!ship || ship->now.mode != INSTANTIATED) {
        return ERROR;
    }
    ship->now.mode = INITIALISING;
    return OK;
}

FUNCTION(fmi2ExitInitializationMode)(void *instance)
{
    struct ship *ship = instance;
    return ship && ship->now.mode == INITIALISING && begun(ship) ? OK : ERROR;
}

static int running(void *instance)
{
    const struct ship *ship = instance;
    return ship && ship->now.mode == RUNNING ? OK : ERROR;
}

FUNCTION(fmi2EnterEventMode)(void *instance) { return running(instance); }
FUNCTION(fmi2EnterContinuousTimeMode)(void *instance) { return running(instance); }
FUNCTION(fmi2Terminate)(void *instance) { return instance ? OK : ERROR; }

FUNCTION(fmi2Reset)(void *instance)
{
    if (!instance) {
        return ERROR;
    }
    reset(instance);
    return OK;
}

FUNCTION(fmi2NewDiscreteStates)(void *instance, struct events *events)
{
    memset(events, 0, sizeof *events);
    return running(instance);
}

// --- Variables -----------------------------------------------------------------------------------

FUNCTION(fmi2GetReal)(void *instance, const unsigned references[], size_t count, double values[])
{
    if (!instance) {
        return ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        if (!got(instance, references[i], &values[i])) {
            return ERROR;
        }
    }
    return OK;
}

FUNCTION(fmi2SetReal)(void *instance, const unsigned references[], size_t count, const double values[])
{
    if (!instance) {
        return ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        if (!put(instance, references[i], values[i])) {
            return ERROR;
        }
    }
    return OK;
}

FUNCTION(fmi2GetBoolean)(void *instance, const unsigned references[], size_t count, int values[])
{
    if (!instance) {
        return ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        double found;
        if (references[i] != V_STEERING_GEAR || !got(instance, references[i], &found)) {
            return ERROR;
        }
        values[i] = found != 0.0;
    }
    return OK;
}

FUNCTION(fmi2SetBoolean)(void *instance, const unsigned references[], size_t count, const int values[])
{
    if (!instance) {
        return ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        if (references[i] != V_STEERING_GEAR || !put(instance, references[i], values[i] ? 1.0 : 0.0)) {
            return ERROR;
        }
    }
    return OK;
}

#define NO_VARIABLES(word, type)                                                                   \
    FUNCTION(fmi2Get##word)(void *instance, const unsigned references[], size_t count, type values[]) \
    {                                                                                              \
        (void)references, (void)values;                                                            \
        return instance && count == 0 ? OK : ERROR;                                                \
    }                                                                                              \
    FUNCTION(fmi2Set##word)(                                                                       \
        void *instance, const unsigned references[], size_t count, const type values[])            \
    {                                                                                              \
        (void)references, (void)values;                                                            \
        return instance && count == 0 ? OK : ERROR;                                                \
    }

typedef const char *string;
NO_VARIABLES(Integer, int)
NO_VARIABLES(String, string)

// --- State ---------------------------------------------------------------------------------------

FUNCTION(fmi2GetFMUstate)(void *instance, void **state)
{
    if (!instance || !state) {
        return ERROR;
    }
    *state = saved(instance, *state);
    return *state ? OK : ERROR;
}

FUNCTION(fmi2SetFMUstate)(void *instance, void *state)
{
    if (!instance || !state) {
        return ERROR;
    }
    ((struct ship *)instance)->now = *(const struct data *)state;
    return OK;
}

FUNCTION(fmi2FreeFMUstate)(void *instance, void **state)
{
    if (!instance || !state) {
        return ERROR;
    }
    free(*state);
    *state = NULL;
    return OK;
}

FUNCTION(fmi2SerializedFMUstateSize)(void *instance, void *state, size_t *size)
{
    if (!instance || !state) {
        return ERROR;
    }
    *size = sizeof(struct data);
    return OK;
}

FUNCTION(fmi2SerializeFMUstate)(void *instance, void *state, char bytes[], size_t size)
{
    if (!instance || !state || size < sizeof(struct data)) {
        return ERROR;
    }
    memcpy(bytes, state, sizeof(struct data));
    return OK;
}

FUNCTION(fmi2DeSerializeFMUstate)(void *instance, const char bytes[], size_t size, void **state)
{
    if (!instance || !state || size != sizeof(struct data)) {
        return ERROR;
    }
    *state = saved(instance, *state);
    if (!*state) {
        return ERROR;
    }
    memcpy(*state, bytes, size);
    return OK;
}

FUNCTION(fmi2GetDirectionalDerivative)(
    void *instance, const unsigned unknowns[], size_t n_unknowns, const unsigned knowns[],
    size_t n_knowns, const double known[], double unknown[])
{
    (void)instance, (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)known;
    (void)unknown;
    return ERROR;
}

// --- Model Exchange ------------------------------------------------------------------------------

FUNCTION(fmi2SetTime)(void *instance, double time)
{
    if (!instance) {
        return ERROR;
    }
    moved(&((struct ship *)instance)->now, time);
    return OK;
}

FUNCTION(fmi2SetContinuousStates)(void *instance, const double states[], size_t count)
{
    struct ship *ship = instance;
    if (!ship || count != STATES) {
        return ERROR;
    }
    memcpy(ship->now.value + FIRST_STATE, states, count * sizeof *states);
    ship->now.evaluated = 0;
    return OK;
}

FUNCTION(fmi2GetContinuousStates)(void *instance, double states[], size_t count)
{
    struct ship *ship = instance;
    if (!ship || count != STATES || !evaluate(ship)) {
        return ERROR;
    }
    memcpy(states, ship->now.value + FIRST_STATE, count * sizeof *states);
    return OK;
}

FUNCTION(fmi2GetDerivatives)(void *instance, double rates[], size_t count)
{
    struct ship *ship = instance;
    if (!ship || count != STATES || !evaluate(ship)) {
        return ERROR;
    }
    memcpy(rates, ship->now.value + FIRST_RATE, count * sizeof *rates);
    return finite_rates(&ship->now) ? OK : DISCARD;
}

FUNCTION(fmi2GetNominalsOfContinuousStates)(void *instance, double nominals[], size_t count)
{
    if (!instance || count != STATES) {
        return ERROR;
    }
    memcpy(nominals, NOMINAL, count * sizeof *nominals);
    return OK;
}

FUNCTION(fmi2GetEventIndicators)(void *instance, double indicators[], size_t count)
{
    (void)indicators;
    return instance && count == 0 ? OK : ERROR;
}

FUNCTION(fmi2CompletedIntegratorStep)(void *instance, int final, int *event, int *terminate)
{
    (void)final;
    *event = *terminate = 0;
    return running(instance);
}

// --- Co-Simulation -------------------------------------------------------------------------------

FUNCTION(fmi2DoStep)(void *instance, double from, double size, int final)
{
    struct ship *ship = instance;
    (void)final;
    if (running(ship) != OK || !ship->steps_itself || !(size >= 0.0)) {
        return ERROR;
    }
    return carried(ship, from, size) ? OK : ERROR;
}

FUNCTION(fmi2CancelStep)(void *instance)
{
    (void)instance;
    return ERROR;
}

FUNCTION(fmi2SetRealInputDerivatives)(
    void *instance, const unsigned references[], size_t count, const int orders[], const double values[])
{
    (void)references, (void)orders, (void)values;
    return instance && count == 0 ? OK : ERROR;
}

FUNCTION(fmi2GetRealOutputDerivatives)(
    void *instance, const unsigned references[], size_t count, const int orders[], double values[])
{
    (void)references, (void)orders, (void)values;
    return instance && count == 0 ? OK : ERROR;
}

FUNCTION(fmi2GetStatus)(void *instance, int what, int *value)
{
    (void)instance, (void)what, (void)value;
    return DISCARD;
}

FUNCTION(fmi2GetRealStatus)(void *instance, int what, double *value)
{
    enum { LAST_SUCCESSFUL_TIME = 2 };
    if (!instance || what != LAST_SUCCESSFUL_TIME) {
        return DISCARD;
    }
    *value = ((const struct ship *)instance)->now.time;
    return OK;
}

FUNCTION(fmi2GetIntegerStatus)(void *instance, int what, int *value)
{
    (void)instance, (void)what, (void)value;
    return DISCARD;
}

FUNCTION(fmi2GetBooleanStatus)(void *instance, int what, int *value)
{
    (void)instance, (void)what, (void)value;
    return DISCARD;
}

FUNCTION(fmi2GetStringStatus)(void *instance, int what, const char **value)
{
    (void)instance, (void)what, (void)value;
    return DISCARD;
}
