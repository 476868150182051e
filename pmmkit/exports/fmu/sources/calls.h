// What a call of FMI 2 and of FMI 3 does alike; fmi2.c and fmi3.c give it their names and types.

// What is seen outside a library; FMI_PREFIX is set before where a prefix is asked for.
#if defined _WIN32
#define EXPORT __declspec(dllexport)
#elif defined __GNUC__
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif
#ifdef FMI_PREFIX
#define JOIN(a, b) a##b
#define JOINED(a, b) JOIN(a, b)
#define NAME(name) JOINED(FMI_PREFIX, name)
#else
#define NAME(name) name
#endif
#define FUNCTION(name) EXPORT int NAME(name)

enum { OK, WARNING, DISCARD, ERROR, FATAL };

// --- Modes ---------------------------------------------------------------------------------------

static int exists(const void *instance) { return instance ? OK : ERROR; }

static int running(const struct ship *ship) { return ship && ship->now.mode == RUNNING ? OK : ERROR; }

static int initialised(struct ship *ship)
{
    return ship && ship->now.mode == INITIALISING && begun(ship) ? OK : ERROR;
}

static int begun_again(struct ship *ship)
{
    if (!ship) {
        return ERROR;
    }
    reset(ship);
    return OK;
}

// --- Variables -----------------------------------------------------------------------------------

static int none(const void *instance, size_t count) { return instance && count == 0 ? OK : ERROR; }

static int got_all(struct ship *ship, const unsigned references[], size_t count, double values[])
{
    if (!ship) {
        return ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        if (!got(ship, references[i], &values[i])) {
            return ERROR;
        }
    }
    return OK;
}

static int put_all(struct ship *ship, const unsigned references[], size_t count, const double values[])
{
    if (!ship) {
        return ERROR;
    }
    for (size_t i = 0; i < count; i++) {
        if (!put(ship, references[i], values[i])) {
            return ERROR;
        }
    }
    return OK;
}

// The only variable that is true or false is whether there is a steering gear.
static int got_switch(struct ship *ship, unsigned reference, int *value)
{
    double found;
    if (reference != V_STEERING_GEAR || !got(ship, reference, &found)) {
        return ERROR;
    }
    *value = found != 0.0;
    return OK;
}

static int put_switch(struct ship *ship, unsigned reference, int value)
{
    return reference == V_STEERING_GEAR && put(ship, reference, value ? 1.0 : 0.0) ? OK : ERROR;
}

// --- State ---------------------------------------------------------------------------------------

static int got_state(const struct ship *ship, void **state)
{
    if (!ship || !state) {
        return ERROR;
    }
    *state = saved(ship, *state);
    return *state ? OK : ERROR;
}

static int put_state(struct ship *ship, const void *state)
{
    if (!ship || !state) {
        return ERROR;
    }
    ship->now = *(const struct data *)state;
    return OK;
}

static int freed_state(const struct ship *ship, void **state)
{
    if (!ship || !state) {
        return ERROR;
    }
    free(*state);
    *state = NULL;
    return OK;
}

static int size_of_state(const struct ship *ship, const void *state, size_t *size)
{
    if (!ship || !state) {
        return ERROR;
    }
    *size = sizeof(struct data);
    return OK;
}

static int state_to_bytes(const struct ship *ship, const void *state, void *bytes, size_t size)
{
    if (!ship || !state || size < sizeof(struct data)) {
        return ERROR;
    }
    memcpy(bytes, state, sizeof(struct data));
    return OK;
}

static int state_from_bytes(const struct ship *ship, const void *bytes, size_t size, void **state)
{
    if (!ship || !state || size != sizeof(struct data)) {
        return ERROR;
    }
    *state = saved(ship, *state);
    if (!*state) {
        return ERROR;
    }
    memcpy(*state, bytes, size);
    return OK;
}

// --- Model Exchange ------------------------------------------------------------------------------

static int put_time(struct ship *ship, double time)
{
    if (!ship) {
        return ERROR;
    }
    moved(&ship->now, time);
    return OK;
}

static int put_states(struct ship *ship, const double states[], size_t count)
{
    if (!ship || count != STATES) {
        return ERROR;
    }
    memcpy(ship->now.value + FIRST_STATE, states, count * sizeof *states);
    ship->now.evaluated = 0;
    return OK;
}

static int got_states(struct ship *ship, double states[], size_t count)
{
    if (!ship || count != STATES || !evaluate(ship)) {
        return ERROR;
    }
    memcpy(states, ship->now.value + FIRST_STATE, count * sizeof *states);
    return OK;
}

static int got_rates(struct ship *ship, double rates[], size_t count)
{
    if (!ship || count != STATES || !evaluate(ship)) {
        return ERROR;
    }
    memcpy(rates, ship->now.value + FIRST_RATE, count * sizeof *rates);
    return finite_rates(&ship->now) ? OK : DISCARD;
}

static int got_nominals(const struct ship *ship, double nominals[], size_t count)
{
    if (!ship || count != STATES) {
        return ERROR;
    }
    memcpy(nominals, NOMINAL, count * sizeof *nominals);
    return OK;
}

// --- Co-Simulation -------------------------------------------------------------------------------

static int stepped(struct ship *ship, double from, double size)
{
    const int can = running(ship) == OK && ship->steps_itself && size >= 0.0;
    return can && carried(ship, from, size) ? OK : ERROR;
}
