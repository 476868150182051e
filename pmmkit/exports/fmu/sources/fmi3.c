// The functions of FMI 3.0 for Model Exchange and Co-Simulation.
//
// The declarations say no more than the standard's interface: types are those of C.

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef FMI3_FUNCTION_PREFIX
#define FMI_PREFIX FMI3_FUNCTION_PREFIX
#endif
#include "equations.h"
#include "ship.h"
#include "calls.h"

typedef void message_callback(void *environment, int status, const char *category, const char *message);

static void say(const struct ship *ship, const char *message)
{
    message_callback *const callback = (message_callback *)(uintptr_t)ship->callback;
    if (callback) {
        callback(ship->environment, ERROR, "logStatusError", message);
    }
}

// --- Instances -----------------------------------------------------------------------------------

EXPORT const char *NAME(fmi3GetVersion)(void) { return "3.0"; }

FUNCTION(fmi3SetDebugLogging)(void *instance, bool on, size_t count, const char *const categories[])
{
    (void)on, (void)count, (void)categories;
    return exists(instance);
}

EXPORT void *NAME(fmi3InstantiateModelExchange)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    void *environment, message_callback *callback)
{
    (void)resources, (void)visible, (void)logging;
    return made(name, token, (const void *)(uintptr_t)callback, environment);
}

EXPORT void *NAME(fmi3InstantiateCoSimulation)(
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

EXPORT void *NAME(fmi3InstantiateScheduledExecution)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    void *environment, message_callback *callback, void (*clock)(void), void (*lock)(void),
    void (*unlock)(void))
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment;
    (void)callback, (void)clock, (void)lock, (void)unlock;
    return NULL;
}

EXPORT void NAME(fmi3FreeInstance)(void *instance) { freed(instance); }

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

FUNCTION(fmi3ExitInitializationMode)(void *instance) { return initialised(instance); }

FUNCTION(fmi3EnterEventMode)(void *instance) { return running(instance); }
FUNCTION(fmi3EnterStepMode)(void *instance) { return running(instance); }
FUNCTION(fmi3EnterContinuousTimeMode)(void *instance) { return running(instance); }
FUNCTION(fmi3Terminate)(void *instance) { return exists(instance); }
FUNCTION(fmi3EnterConfigurationMode)(void *instance) { return exists(instance); }
FUNCTION(fmi3ExitConfigurationMode)(void *instance) { return exists(instance); }
FUNCTION(fmi3EvaluateDiscreteStates)(void *instance) { return running(instance); }

FUNCTION(fmi3Reset)(void *instance) { return begun_again(instance); }

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
    return count == size ? got_all(instance, references, count, values) : ERROR;
}

FUNCTION(fmi3SetFloat64)(
    void *instance, const uint32_t references[], size_t count, const double values[], size_t size)
{
    return count == size ? put_all(instance, references, count, values) : ERROR;
}

FUNCTION(fmi3GetBoolean)(
    void *instance, const uint32_t references[], size_t count, bool values[], size_t size)
{
    if (!instance || count != size) {
        return ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        int found;
        if (got_switch(instance, references[i], &found) != OK) {
            return ERROR;
        }
        values[i] = found;
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
        if (put_switch(instance, references[i], values[i]) != OK) {
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
        return none(instance, count);                                                              \
    }                                                                                              \
    FUNCTION(fmi3Set##word)(                                                                       \
        void *instance, const uint32_t references[], size_t count, const type values[], size_t size) \
    {                                                                                              \
        (void)references, (void)values, (void)size;                                                \
        return none(instance, count);                                                              \
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
    return none(instance, count);
}

FUNCTION(fmi3SetBinary)(
    void *instance, const uint32_t references[], size_t count, const size_t sizes[],
    const uint8_t *const values[], size_t size)
{
    (void)references, (void)sizes, (void)values, (void)size;
    return none(instance, count);
}

FUNCTION(fmi3GetClock)(void *instance, const uint32_t references[], size_t count, bool values[])
{
    (void)references, (void)values;
    return none(instance, count);
}

FUNCTION(fmi3SetClock)(void *instance, const uint32_t references[], size_t count, const bool values[])
{
    (void)references, (void)values;
    return none(instance, count);
}

// --- State ---------------------------------------------------------------------------------------

FUNCTION(fmi3GetFMUState)(void *instance, void **state) { return got_state(instance, state); }

FUNCTION(fmi3SetFMUState)(void *instance, void *state) { return put_state(instance, state); }

FUNCTION(fmi3FreeFMUState)(void *instance, void **state) { return freed_state(instance, state); }

FUNCTION(fmi3SerializedFMUStateSize)(void *instance, void *state, size_t *size)
{
    return size_of_state(instance, state, size);
}

FUNCTION(fmi3SerializeFMUState)(void *instance, void *state, uint8_t bytes[], size_t size)
{
    return state_to_bytes(instance, state, bytes, size);
}

FUNCTION(fmi3DeserializeFMUState)(void *instance, const uint8_t bytes[], size_t size, void **state)
{
    return state_from_bytes(instance, bytes, size, state);
}

// --- Model Exchange ------------------------------------------------------------------------------

FUNCTION(fmi3SetTime)(void *instance, double time) { return put_time(instance, time); }

FUNCTION(fmi3SetContinuousStates)(void *instance, const double states[], size_t count)
{
    return put_states(instance, states, count);
}

FUNCTION(fmi3GetContinuousStates)(void *instance, double states[], size_t count)
{
    return got_states(instance, states, count);
}

FUNCTION(fmi3GetContinuousStateDerivatives)(void *instance, double rates[], size_t count)
{
    return got_rates(instance, rates, count);
}

FUNCTION(fmi3GetNominalsOfContinuousStates)(void *instance, double nominals[], size_t count)
{
    return got_nominals(instance, nominals, count);
}

FUNCTION(fmi3GetNumberOfContinuousStates)(void *instance, size_t *count)
{
    *count = STATES;
    return exists(instance);
}

FUNCTION(fmi3GetNumberOfEventIndicators)(void *instance, size_t *count)
{
    *count = 0;
    return exists(instance);
}

FUNCTION(fmi3GetEventIndicators)(void *instance, double indicators[], size_t count)
{
    (void)indicators;
    return none(instance, count);
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
    const int done = stepped(ship, from, size);
    *reached = ship ? ship->now.time : from;
    return done;
}

FUNCTION(fmi3GetOutputDerivatives)(
    void *instance, const uint32_t references[], size_t count, const int32_t orders[],
    double values[], size_t size)
{
    (void)references, (void)orders, (void)values, (void)size;
    return none(instance, count);
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
