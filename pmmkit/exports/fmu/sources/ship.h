// A ship as an instance of an FMU: what FMI 2 and FMI 3 have in common.
//
// equations.h, which comes before, holds the equations and the table of variables: `value` of an
// instance has a place for each, the value reference is the place.

#include <stdlib.h>
#include <string.h>

enum mode { INSTANTIATED, INITIALISING, RUNNING };

struct data {
    enum mode mode;
    int evaluated;
    int ordered;
    double time;
    double step;
    double tolerance;
    double value[VARIABLES];
    double k[CONSTANTS];
    double gear[GEARS];
};

struct ship {
    struct data now;
    int steps_itself;
    char *name;
    void *environment;
    const void *callback;
};

static void say(const struct ship *ship, const char *message);

static void reset(struct ship *ship)
{
    memset(&ship->now, 0, sizeof ship->now);
    memcpy(ship->now.value, START, sizeof START);
    ship->now.tolerance = TOLERANCE;
    ship->now.step = LONGEST_STEP;
}

static struct ship *made(const char *name, const char *token, const void *callback, void *environment)
{
    struct ship *ship = calloc(1, sizeof *ship);
    if (!ship) {
        return NULL;
    }
    ship->callback = callback;
    ship->environment = environment;
    ship->name = calloc(name ? strlen(name) + 1 : 1, 1);
    if (ship->name && name) {
        strcpy(ship->name, name);
    }
    reset(ship);
    if (!token || strcmp(token, TOKEN) != 0) {
        say(ship, "The token or GUID is not that of modelDescription.xml: another FMU's description?");
        free(ship->name);
        free(ship);
        return NULL;
    }
    return ship;
}

static void freed(struct ship *ship)
{
    if (ship) {
        free(ship->name);
        free(ship);
    }
}

// The constants of the equations from the parameters; 0 if they make no ship.
static int constants(struct ship *ship)
{
    struct data *now = &ship->now;
    memcpy(now->k, BASE, sizeof BASE);
    for (int i = 0; i < SLOPES; i++) {
        now->k[SLOPE[i].place] += SLOPE[i].size * now->value[SLOPE[i].variable];
    }
    if (eq_complete(now->k)) {
        say(ship, "The mass matrix is not positive. Check mass, Izz and the acceleration derivatives.");
        return 0;
    }
    if (!(now->value[V_DELTA_LAG] > 0.0 && now->value[V_DELTA_RATE] > 0.0)) {
        say(ship, "delta_lag and delta_rate must be positive. For a rudder that is at its order at "
                  "once set steering_gear to false.");
        return 0;
    }
    return 1;
}

static void surroundings(struct data *now)
{
    const double *v = now->value;
    const struct numbers_2 water = eq_flow(v[V_CURRENT_SPEED], v[V_CURRENT_DIRECTION]);
    now->k[K_CURRENT_X] = water.v0;
    now->k[K_CURRENT_Y] = water.v1;
#ifdef V_WIND_SPEED
    const struct numbers_2 wind
        = eq_wind_over_current(v[V_WIND_SPEED], v[V_WIND_DIRECTION], water.v0, water.v1);
    now->k[K_WIND_SPEED] = wind.v0;
    now->k[K_WIND_DIRECTION] = wind.v1;
#endif
#ifdef V_WAVE_HEIGHT
    now->k[K_WAVE_HEIGHT] = v[V_WAVE_HEIGHT];
    now->k[K_WAVE_DIRECTION] = v[V_WAVE_DIRECTION];
#endif
}

static double wanted_rudder(const struct data *now)
{
    const double most = now->value[V_DELTA_MAX];
    return larger(smaller(now->value[V_DELTA_ORDER], most), -most);
}

static double wanted_revolutions(const struct data *now)
{
#ifdef V_N_ORDER
    return now->value[V_N_ORDER];
#else
    return 0.0 * now->time;
#endif
}

static double wanted_bucket(const struct data *now)
{
#ifdef V_BUCKET
    return now->value[V_BUCKET];
#else
    return 0.0 * now->time;
#endif
}

// Everything that follows from states, inputs and parameters; 0 if that is impossible.
static int evaluate(struct ship *ship)
{
    struct data *now = &ship->now;
    double *v = now->value;
    if (now->evaluated) {
        return 1;
    }
    if (now->mode != RUNNING) {
        if (!constants(ship)) {
            return 0;
        }
        memcpy(v + FIRST_STATE, v + FIRST_BEGIN, STATES * sizeof *v);
    }
    surroundings(now);
#ifdef V_N_APPROACH
    if (now->mode != RUNNING) {
        double y[STATES] = {0.0}, out[STATES] = {0.0};
        v[V_N_APPROACH] = eq_self_propulsion(v[FIRST_STATE + U_STATE], now->k, y, out);
    }
#endif
    const int gear = v[V_STEERING_GEAR] != 0.0;
    const double delta = gear ? v[GEAR_STATE] : v[V_DELTA_ORDER];
    const double n = wanted_revolutions(now), bucket = wanted_bucket(now);
    eq_rates(v + FIRST_STATE, delta, n, bucket, now->k, v + FIRST_RATE);
    eq_forces(v + FIRST_STATE, delta, n, bucket, now->k, v + FIRST_FORCE);
    v[GEAR_RATE] = gear ? eq_gear_rate(v[GEAR_STATE], wanted_rudder(now), v[V_DELTA_RATE], v[V_DELTA_LAG])
                        : 0.0;
    v[V_DELTA] = delta;
#ifdef V_N
    v[V_N] = n;
#endif
    now->evaluated = 1;
    return 1;
}

// Whether the accelerations are numbers: 0 where the motion has left what the model describes.
static int finite_rates(const struct data *now)
{
    for (int i = 0; i < STATES; i++) {
        if (!isfinite(now->value[FIRST_RATE + i])) {
            return 0;
        }
    }
    return 1;
}

static int got(struct ship *ship, unsigned reference, double *value)
{
    if (reference >= VARIABLES) {
        say(ship, "There is no variable of this value reference.");
        return 0;
    }
    if (reference < FIRST_INPUT && !evaluate(ship)) {
        return 0;
    }
    *value = reference == V_TIME ? ship->now.time : ship->now.value[reference];
    return 1;
}

static int put(struct ship *ship, unsigned reference, double value)
{
    struct data *now = &ship->now;
    if (reference >= VARIABLES || reference < FIRST_INPUT) {
        say(ship, "Only inputs and parameters are set; how a state begins is a parameter such as u_start.");
        return 0;
    }
    if (reference >= FIRST_PARAMETER && now->mode == RUNNING) {
        say(ship, "A parameter is set before the end of the initialisation.");
        return 0;
    }
    now->value[reference] = value;
    now->evaluated = 0;
    return 1;
}

// Leave the initialisation; 0 if the parameters make no ship.
static int begun(struct ship *ship)
{
    ship->now.evaluated = 0;
    if (!evaluate(ship)) {
        return 0;
    }
    ship->now.mode = RUNNING;
    return 1;
}

// Take over the tolerance of the program that runs the FMU, as far as numbers can be that close.
static void tolerate(struct data *now, int defined, double tolerance)
{
    if (defined && tolerance > 0.0) {
        now->tolerance = larger(tolerance, CLOSEST);
    }
}

static void moved(struct data *now, double time)
{
    now->time = time;
    now->evaluated = 0;
}

// Carry the ship on while the inputs are held; 0 where it comes to no end.
static int carried(struct ship *ship, double from, double size)
{
    struct data *now = &ship->now;
    double *v = now->value, *g = now->gear;
    const double end = from + size;
    const double n = wanted_revolutions(now), bucket = wanted_bucket(now);
    const int gear = v[V_STEERING_GEAR] != 0.0;
    const double order = gear ? wanted_rudder(now) : v[V_DELTA_ORDER];
    if (!now->ordered || order != g[RUDDER_ORDER]) {
        eq_ordered(g, RUDDER, from, gear ? v[GEAR_STATE] : order, order, v[V_DELTA_RATE], v[V_DELTA_LAG]);
    }
    eq_ordered(g, REVOLUTIONS, from, n, n, 1.0, 0.0);
    eq_ordered(g, BUCKET, from, bucket, bucket, 1.0, 0.0);
    now->ordered = 1;
    surroundings(now);
    const struct numbers_2 reached = eq_carried(
        from, end, now->step, v + FIRST_STATE, g, now->k, now->tolerance, LONGEST_STEP);
    now->step = reached.v1;
    moved(now, reached.v0 < end ? reached.v0 : end);
    if (gear) {
        v[GEAR_STATE] = eq_controlled(now->time, g, RUDDER);
    }
    if (end - now->time > 1e-9 * (1.0 + fabs(end))) {
        say(ship, "The motion leaves what the model describes: it grows without bound or the ship "
                  "capsizes. Use less rudder, or check the derivatives.");
        return 0;
    }
    moved(now, end);
    return 1;
}

static struct data *saved(const struct ship *ship, struct data *room)
{
    struct data *copy = room ? room : malloc(sizeof *copy);
    if (copy) {
        *copy = ship->now;
    }
    return copy;
}
