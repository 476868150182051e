// The functions of FMI 3.0 for Model Exchange and Co-Simulation.
//
// The declarations say no more than the standard's interface: types are those of C.

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "equations.h"
#include "ship.h"

#ifndef FMI3_Export
#if defined _WIN32
#define FMI3_Export __declspec(dllexport)
#elif defined __GNUC__
#define FMI3_Export __attribute__((visibility("default")))
#else
#define FMI3_Export
#endif
#endif
#ifdef FMI3_FUNCTION_PREFIX
#define JOIN(a, b) a##b
#define JOINED(a, b) JOIN(a, b)
#define NAME(name) JOINED(FMI3_FUNCTION_PREFIX, name)
#else
#define NAME(name) name
#endif
#define FUNCTION(name) FMI3_Export int NAME(name)

enum { OK, WARNING, DISCARD, ERROR, FATAL };
typedef void message_callback(void *environment, int status, const char *category, const char *message);

static void say(const struct ship *ship, const char *message)
{
    message_callback *const callback = (message_callback *)(uintptr_t)ship->callback;
    if (callback) {
        callback(ship->environment, ERROR, "logStatusError", message);
    }
}

// --- Instances -----------------------------------------------------------------------------------

FMI3_Export const char *NAME(fmi3GetVersion)(void) { return "3.0"; }

FUNCTION(fmi3SetDebugLogging)(void *instance, bool on, size_t count, const char *const categories[])
{
    (void)on, (void)count, (void)categories;
    return instance ? OK : ERROR;
}

FMI3_Export void *NAME(fmi3InstantiateModelExchange)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    void *environment, message_callback *callback)
{
    (void)resources, (void)visible, (void)logging;
    return made(name, token, (const void *)(uintptr_t)callback, environment);
}

FMI3_Export void *NAME(fmi3InstantiateCoSimulation)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    bool events, bool early, const uint32_t intermediate[], size_t count, void *environment,
    message_callback *callback, void (*update)(void))
{
    (void)resources, (void)visible, (void)logging, (void)events, (void)early, (void)intermediate;
    (void)count, (void)update;
    struct ship *ship = made(name, token, (const void *)(uintptr_t)callback, environment);
    if (ship) {
        ship->steps_itself = 1;
    }
    return ship;
}

FMI3_Export void *NAME(fmi3InstantiateScheduledExecution)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    void *environment, message_callback *callback, void (*clock)(void), void (*lock)(void),
    void (*unlock)(void))
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment;
    (void)callback, (void)clock, (void)lock, (void)unlock;
    return NULL;
}

FMI3_Export void NAME(fmi3FreeInstance)(void *instance) { freed(instance); }

// --- Modes ---------------------------------------------------------------------------------------

FUNCTION(fmi3EnterInitializationMode)(
    void *instance, bool with_tolerance, double tolerance, double start, bool with_stop, double stop)
{
    struct ship *ship = instance;
    (void)with_stop, (void)stop;
    if (!ship || ship->now.mode != INSTANTIATED) {
        return ERROR;
    }
    tolerate(&ship->now, with_tolerance, tolerance);
    ship->now.mode = INITIALISING;
    moved(&ship->now, start);
    return OK;
}

FUNCTION(fmi3ExitInitializationMode)(void *instance)
{
    struct ship *ship = instance;
    return ship && ship->now.mode == INITIALISING && begun(ship) ? OK : ERROR;
}

static int running(void *instance)
{
    const struct ship *ship = instance;
    return ship && ship->now.mode == RUNNING ? OK : ERROR;
}

FUNCTION(fmi3EnterEventMode)(void *instance) { return running(instance); }
FUNCTION(fmi3EnterStepMode)(void *instance) { return running(instance); }
FUNCTION(fmi3EnterContinuousTimeMode)(void *instance) { return running(instance); }
FUNCTION(fmi3Terminate)(void *instance) { return instance ? OK : ERROR; }
FUNCTION(fmi3EnterConfigurationMode)(void *instance) { return instance ? OK : ERROR; }
FUNCTION(fmi3ExitConfigurationMode)(void *instance) { return instance ? OK : ERROR; }
FUNCTION(fmi3EvaluateDiscreteStates)(void *instance) { return running(instance); }

FUNCTION(fmi3Reset)(void *instance)
{
    if (!instance) {
        return ERROR;
    }
    reset(instance);
    return OK;
}

FUNCTION(fmi3UpdateDiscreteStates)(
    void *instance, bool *again, bool *terminate, bool *nominals, bool *values, bool *timed, double *time)
{
    *again = *terminate = *nominals = *values = *timed = false;
    *time = 0.0;
    return running(instance);
}

// --- Variables -----------------------------------------------------------------------------------

FUNCTION(fmi3GetFloat64)(
    void *instance, const uint32_t references[], size_t count, double values[], size_t size)
{
    if (!instance || count != size) {
        return ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        if (!got(instance, references[i], &values[i])) {
            return ERROR;
        }
    }
    return OK;
}

FUNCTION(fmi3SetFloat64)(
    void *instance, const uint32_t references[], size_t count, const double values[], size_t size)
{
    if (!instance || count != size) {
        return ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        if (!put(instance, references[i], values[i])) {
            return ERROR;
        }
    }
    return OK;
}

FUNCTION(fmi3GetBoolean)(
    void *instance, const uint32_t references[], size_t count, bool values[], size_t size)
{
    if (!instance || count != size) {
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

FUNCTION(fmi3SetBoolean)(
    void *instance, const uint32_t references[], size_t count, const bool values[], size_t size)
{
    if (!instance || count != size) {
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
    FUNCTION(fmi3Get##word)(                                                                       \
        void *instance, const uint32_t references[], size_t count, type values[], size_t size)     \
    {                                                                                              \
        (void)references, (void)values, (void)size;                                                \
        return instance && count == 0 ? OK : ERROR;                                                \
    }                                                                                              \
    FUNCTION(fmi3Set##word)(                                                                       \
        void *instance, const uint32_t references[], size_t count, const type values[], size_t size) \
    {                                                                                              \
        (void)references, (void)values, (void)size;                                                \
        return instance && count == 0 ? OK : ERROR;                                                \
    }

NO_VARIABLES(Float32, float)
NO_VARIABLES(Int8, int8_t)
NO_VARIABLES(UInt8, uint8_t)
NO_VARIABLES(Int16, int16_t)
NO_VARIABLES(UInt16, uint16_t)
NO_VARIABLES(Int32, int32_t)
NO_VARIABLES(UInt32, uint32_t)
NO_VARIABLES(Int64, int64_t)
NO_VARIABLES(UInt64, uint64_t)

typedef const char *string;
NO_VARIABLES(String, string)

FUNCTION(fmi3GetBinary)(
    void *instance, const uint32_t references[], size_t count, size_t sizes[],
    const uint8_t *values[], size_t size)
{
    (void)references, (void)sizes, (void)values, (void)size;
    return instance && count == 0 ? OK : ERROR;
}

FUNCTION(fmi3SetBinary)(
    void *instance, const uint32_t references[], size_t count, const size_t sizes[],
    const uint8_t *const values[], size_t size)
{
    (void)references, (void)sizes, (void)values, (void)size;
    return instance && count == 0 ? OK : ERROR;
}

FUNCTION(fmi3GetClock)(void *instance, const uint32_t references[], size_t count, bool values[])
{
    (void)references, (void)values;
    return instance && count == 0 ? OK : ERROR;
}

FUNCTION(fmi3SetClock)(void *instance, const uint32_t references[], size_t count, const bool values[])
{
    (void)references, (void)values;
    return instance && count == 0 ? OK : ERROR;
}

// --- State ---------------------------------------------------------------------------------------

FUNCTION(fmi3GetFMUState)(void *instance, void **state)
{
    if (!instance || !state) {
        return ERROR;
    }
    *state = saved(instance, *state);
    return *state ? OK : ERROR;
}

FUNCTION(fmi3SetFMUState)(void *instance, void *state)
{
    if (!instance || !state) {
        return ERROR;
    }
    ((struct ship *)instance)->now = *(const struct data *)state;
    return OK;
}

FUNCTION(fmi3FreeFMUState)(void *instance, void **state)
{
    if (!instance || !state) {
        return ERROR;
    }
    free(*state);
    *state = NULL;
    return OK;
}

FUNCTION(fmi3SerializedFMUStateSize)(void *instance, void *state, size_t *size)
{
    if (!instance || !state) {
        return ERROR;
    }
    *size = sizeof(struct data);
    return OK;
}

FUNCTION(fmi3SerializeFMUState)(void *instance, void *state, uint8_t bytes[], size_t size)
{
    if (!instance || !state || size < sizeof(struct data)) {
        return ERROR;
    }
    memcpy(bytes, state, sizeof(struct data));
    return OK;
}

FUNCTION(fmi3DeserializeFMUState)(void *instance, const uint8_t bytes[], size_t size, void **state)
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

// --- Model Exchange ------------------------------------------------------------------------------

FUNCTION(fmi3SetTime)(void *instance, double time)
{
    if (!instance) {
        return ERROR;
    }
    moved(&((struct ship *)instance)->now, time);
    return OK;
}

FUNCTION(fmi3SetContinuousStates)(void *instance, const double states[], size_t count)
{
    struct ship *ship = instance;
    if (!ship || count != STATES) {
        return ERROR;
    }
    memcpy(ship->now.value + FIRST_STATE, states, count * sizeof *states);
    ship->now.evaluated = 0;
    return OK;
}

FUNCTION(fmi3GetContinuousStates)(void *instance, double states[], size_t count)
{
    struct ship *ship = instance;
    if (!ship || count != STATES || !evaluate(ship)) {
        return ERROR;
    }
    memcpy(states, ship->now.value + FIRST_STATE, count * sizeof *states);
    return OK;
}

FUNCTION(fmi3GetContinuousStateDerivatives)(void *instance, double rates[], size_t count)
{
    struct ship *ship = instance;
    if (!ship || count != STATES || !evaluate(ship)) {
        return ERROR;
    }
    memcpy(rates, ship->now.value + FIRST_RATE, count * sizeof *rates);
    return finite_rates(&ship->now) ? OK : DISCARD;
}

FUNCTION(fmi3GetNominalsOfContinuousStates)(void *instance, double nominals[], size_t count)
{
    if (!instance || count != STATES) {
        return ERROR;
    }
    memcpy(nominals, NOMINAL, count * sizeof *nominals);
    return OK;
}

FUNCTION(fmi3GetNumberOfContinuousStates)(void *instance, size_t *count)
{
    *count = STATES;
    return instance ? OK : ERROR;
}

FUNCTION(fmi3GetNumberOfEventIndicators)(void *instance, size_t *count)
{
    *count = 0;
    return instance ? OK : ERROR;
}

FUNCTION(fmi3GetEventIndicators)(void *instance, double indicators[], size_t count)
{
    (void)indicators;
    return instance && count == 0 ? OK : ERROR;
}

FUNCTION(fmi3CompletedIntegratorStep)(void *instance, bool final, bool *event, bool *terminate)
{
    (void)final;
    *event = *terminate = false;
    return running(instance);
}

// --- Co-Simulation -------------------------------------------------------------------------------

FUNCTION(fmi3DoStep)(
    void *instance, double from, double size, bool final, bool *event, bool *terminate, bool *early,
    double *reached)
{
    struct ship *ship = instance;
    (void)final;
    *event = *terminate = *early = false;
    *reached = from;
    if (running(ship) != OK || !ship->steps_itself || !(size >= 0.0)) {
        return ERROR;
    }
    const int done = carried(ship, from, size);
    *reached = ship->now.time;
    return done ? OK : ERROR;
}

FUNCTION(fmi3GetOutputDerivatives)(
    void *instance, const uint32_t references[], size_t count, const int32_t orders[],
    double values[], size_t size)
{
    (void)references, (void)orders, (void)values, (void)size;
    return instance && count == 0 ? OK : ERROR;
}

// --- What this FMU does not have -----------------------------------------------------------------

FUNCTION(fmi3GetNumberOfVariableDependencies)(void *instance, uint32_t reference, size_t *count)
{
    (void)instance, (void)reference;
    *count = 0;
    return ERROR;
}

FUNCTION(fmi3GetVariableDependencies)(
    void *instance, uint32_t dependent, size_t elements[], uint32_t independents[],
    size_t of_independents[], int kinds[], size_t count)
{
    (void)instance, (void)dependent, (void)elements, (void)independents, (void)of_independents;
    (void)kinds, (void)count;
    return ERROR;
}

#define NO_DERIVATIVES(name)                                                                       \
    FUNCTION(name)(                                                                                \
        void *instance, const uint32_t unknowns[], size_t n_unknowns, const uint32_t knowns[],     \
        size_t n_knowns, const double seed[], size_t n_seed, double found[], size_t n_found)       \
    {                                                                                              \
        (void)instance, (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns;            \
        (void)seed, (void)n_seed, (void)found, (void)n_found;                                      \
        return ERROR;                                                                              \
    }

NO_DERIVATIVES(fmi3GetDirectionalDerivative)
NO_DERIVATIVES(fmi3GetAdjointDerivative)

FUNCTION(fmi3GetIntervalDecimal)(
    void *instance, const uint32_t references[], size_t count, double intervals[], int qualifiers[])
{
    (void)instance, (void)references, (void)count, (void)intervals, (void)qualifiers;
    return ERROR;
}

FUNCTION(fmi3GetIntervalFraction)(
    void *instance, const uint32_t references[], size_t count, uint64_t counters[],
    uint64_t resolutions[], int qualifiers[])
{
    (void)instance, (void)references, (void)count, (void)counters, (void)resolutions;
    (void)qualifiers;
    return ERROR;
}

#define NO_CLOCKS(word, decimal, fraction)                                                         \
    FUNCTION(fmi3##word##Decimal)(                                                                 \
        void *instance, const uint32_t references[], size_t count, decimal)                        \
    {                                                                                              \
        (void)instance, (void)references, (void)count, (void)values;                               \
        return ERROR;                                                                              \
    }                                                                                              \
    FUNCTION(fmi3##word##Fraction)(                                                                \
        void *instance, const uint32_t references[], size_t count, fraction counters[],            \
        fraction resolutions[])                                                                    \
    {                                                                                              \
        (void)instance, (void)references, (void)count, (void)counters, (void)resolutions;          \
        return ERROR;                                                                              \
    }

NO_CLOCKS(GetShift, double values[], uint64_t)
NO_CLOCKS(SetShift, const double values[], const uint64_t)
NO_CLOCKS(SetInterval, const double values[], const uint64_t)

FUNCTION(fmi3ActivateModelPartition)(void *instance, uint32_t clock, double time)
{
    (void)instance, (void)clock, (void)time;
    return ERROR;
}
