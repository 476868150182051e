// The functions of FMI 2.0 for Model Exchange and Co-Simulation.
//
// The declarations say no more than the standard's interface: types are those of C.

#include <stddef.h>
#include <stdint.h>

#ifdef FMI2_FUNCTION_PREFIX
#define FMI_PREFIX FMI2_FUNCTION_PREFIX
#endif
#include "equations.h"
#include "ship.h"
#include "calls.h"

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

EXPORT const char *NAME(fmi2GetTypesPlatform)(void) { return "default"; }
EXPORT const char *NAME(fmi2GetVersion)(void) { return "2.0"; }

FUNCTION(fmi2SetDebugLogging)(void *instance, int on, size_t count, const char *const categories[])
{
    (void)on, (void)count, (void)categories;
    return exists(instance);
}

EXPORT void *NAME(fmi2Instantiate)(
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

EXPORT void NAME(fmi2FreeInstance)(void *instance) { freed(instance); }

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

FUNCTION(fmi2ExitInitializationMode)(void *instance) { return initialised(instance); }

FUNCTION(fmi2EnterEventMode)(void *instance) { return running(instance); }
FUNCTION(fmi2EnterContinuousTimeMode)(void *instance) { return running(instance); }
FUNCTION(fmi2Terminate)(void *instance) { return exists(instance); }

FUNCTION(fmi2Reset)(void *instance) { return begun_again(instance); }

FUNCTION(fmi2NewDiscreteStates)(void *instance, struct events *events)
{
    memset(events, 0, sizeof *events);
    return running(instance);
}

// --- Variables -----------------------------------------------------------------------------------

FUNCTION(fmi2GetReal)(void *instance, const unsigned references[], size_t count, double values[])
{
    return got_all(instance, references, count, values);
}

FUNCTION(fmi2SetReal)(void *instance, const unsigned references[], size_t count, const double values[])
{
    return put_all(instance, references, count, values);
}

FUNCTION(fmi2GetBoolean)(void *instance, const unsigned references[], size_t count, int values[])
{
    if (!instance) {
        return ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        if (got_switch(instance, references[i], &values[i]) != OK) {
            return ERROR;
        }
    }
    return OK;
}

FUNCTION(fmi2SetBoolean)(void *instance, const unsigned references[], size_t count, const int values[])
{
    if (!instance) {
        return ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        if (put_switch(instance, references[i], values[i]) != OK) {
            return ERROR;
        }
    }
    return OK;
}

#define NO_VARIABLES(word, type)                                                                   \
    FUNCTION(fmi2Get##word)(void *instance, const unsigned references[], size_t count, type values[]) \
    {                                                                                              \
        (void)references, (void)values;                                                            \
        return none(instance, count);                                                              \
    }                                                                                              \
    FUNCTION(fmi2Set##word)(                                                                       \
        void *instance, const unsigned references[], size_t count, const type values[])            \
    {                                                                                              \
        (void)references, (void)values;                                                            \
        return none(instance, count);                                                              \
    }

typedef const char *string;
NO_VARIABLES(Integer, int)
NO_VARIABLES(String, string)

// --- State ---------------------------------------------------------------------------------------

FUNCTION(fmi2GetFMUstate)(void *instance, void **state) { return got_state(instance, state); }

FUNCTION(fmi2SetFMUstate)(void *instance, void *state) { return put_state(instance, state); }

FUNCTION(fmi2FreeFMUstate)(void *instance, void **state) { return freed_state(instance, state); }

FUNCTION(fmi2SerializedFMUstateSize)(void *instance, void *state, size_t *size)
{
    return size_of_state(instance, state, size);
}

FUNCTION(fmi2SerializeFMUstate)(void *instance, void *state, char bytes[], size_t size)
{
    return state_to_bytes(instance, state, bytes, size);
}

FUNCTION(fmi2DeSerializeFMUstate)(void *instance, const char bytes[], size_t size, void **state)
{
    return state_from_bytes(instance, bytes, size, state);
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

FUNCTION(fmi2SetTime)(void *instance, double time) { return put_time(instance, time); }

FUNCTION(fmi2SetContinuousStates)(void *instance, const double states[], size_t count)
{
    return put_states(instance, states, count);
}

FUNCTION(fmi2GetContinuousStates)(void *instance, double states[], size_t count)
{
    return got_states(instance, states, count);
}

FUNCTION(fmi2GetDerivatives)(void *instance, double rates[], size_t count)
{
    return got_rates(instance, rates, count);
}

FUNCTION(fmi2GetNominalsOfContinuousStates)(void *instance, double nominals[], size_t count)
{
    return got_nominals(instance, nominals, count);
}

FUNCTION(fmi2GetEventIndicators)(void *instance, double indicators[], size_t count)
{
    (void)indicators;
    return none(instance, count);
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
    (void)final;
    return stepped(instance, from, size);
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
    return none(instance, count);
}

FUNCTION(fmi2GetRealOutputDerivatives)(
    void *instance, const unsigned references[], size_t count, const int orders[], double values[])
{
    (void)references, (void)orders, (void)values;
    return none(instance, count);
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
