/* The right-hand side of the KVLCC2's MMG equations (3 degrees of freedom), written by hand, as a
   measure of what a compiler makes of it. The constants are those of pmmkit, at the places that the
   macros K_... name; benchmark_engine.py defines them and checks the result. */
#include <math.h>
#include <time.h>

static inline void rates(const double *y, double delta, double n, const double *k, double *out)
{
    const double psi = y[2], u = y[3], v = y[4], r = y[5];
    const double L = k[0], mass = k[3], rho = k[6], xG = k[8];
    const double U = fmax(sqrt(u * u + v * v), 1e-9), inv = 1.0 / U, s = U * U;
    const double vp = v * inv, rp = r * L * inv;
    const double vv = vp * vp, vr = vp * rp, rr = rp * rp;

    double X = s * (K_X0 + K_XVV * vv + K_XVR * vr + K_XRR * rr + K_XVVVV * vv * vv);
    double Y = s * (K_YV * vp + K_YR * rp + K_YVVV * vv * vp + K_YVVR * vv * rp
                    + K_YVRR * vp * rr + K_YRRR * rr * rp);
    double N = s * (K_NV * vp + K_NR * rp + K_NVVV * vv * vp + K_NVVR * vv * rp
                    + K_NVRR * vp * rr + K_NRRR * rr * rp);

    const double beta = atan2(-v, u);
    const double bp = beta - K_XP * rp;
    const double C2 = bp > 0.0 ? K_C2P : K_C2N;
    const double uP = u * (1.0 - K_WP) * (1.0 + (1.0 - exp(-K_C1 * fabs(bp))) * (C2 - 1.0));
    const double tip = n * K_D;
    const double load = K_KT0 * tip * fabs(tip) + K_KT1 * fabs(tip) * uP + K_KT2 * uP * uP;
    X += (1.0 - K_T) * rho * K_D * K_D * load;

    const double behind = sqrt(fmax(uP * uP + 8.0 / M_PI * load, 0.0));
    const double mixed = uP + K_KAPPA * (behind - uP);
    const double uR = K_EPS * sqrt(fmax(K_ETA * mixed * mixed + (1.0 - K_ETA) * uP * uP, 0.0));
    const double bR = beta - K_LR * rp;
    const double vR = -(bR > 0.0 ? K_GP : K_GN) * bR * U;
    const double cd = cos(delta), sd = sin(delta);
    const double FN = -0.5 * rho * K_AREA * K_FA * sqrt(uR * uR + vR * vR) * (uR * sd + vR * cd);
    const double side = FN * cd;
    X += (1.0 - K_TR) * FN * sd;
    Y += (1.0 + K_AH) * side;
    N += (K_XR + K_AH * K_XH) * L * side;

    X += (mass + k[23]) * v * r + mass * xG * r * r;
    Y += (k[24] - mass) * u * r;
    N -= mass * xG * u * r;
    const double c = cos(psi), sn = sin(psi);
    out[0] = u * c - v * sn;
    out[1] = u * sn + v * c;
    out[2] = r;
    out[3] = X / k[26];
    out[4] = k[27] * Y + k[28] * N;
    out[5] = k[30] * Y + k[31] * N;
}

void one(const double *y, double delta, double n, const double *k, double *out)
{
    rates(y, delta, n, k, out);
}

/* Seconds for right-hand sides at slightly different states; their sum goes to `total`. */
double repeat(double *y, const double *k, long times, double *total)
{
    struct timespec a, b;
    double out[6], sum = 0.0;
    clock_gettime(CLOCK_MONOTONIC, &a);
    for (long i = 0; i < times; i++) {
        y[3] += 1e-9;
        rates(y, 0.3 + 1e-9 * i, 1.0, k, out);
        sum += out[3] + out[4] + out[5];
    }
    clock_gettime(CLOCK_MONOTONIC, &b);
    *total = sum;
    return (b.tv_sec - a.tv_sec) + 1e-9 * (b.tv_nsec - a.tv_nsec);
}

/* Seconds for a turn in equal steps of the classical Runge-Kutta method. */
double turn(double *y, const double *k, double order, double rate, double n, double end, long steps)
{
    struct timespec a, b;
    double k1[6], k2[6], k3[6], k4[6], z[6];
    const double h = end / steps;
    clock_gettime(CLOCK_MONOTONIC, &a);
    for (long i = 0; i < steps; i++) {
        const double t = i * h;
        rates(y, fmin(rate * t, order), n, k, k1);
        for (int j = 0; j < 6; j++) z[j] = y[j] + 0.5 * h * k1[j];
        rates(z, fmin(rate * (t + 0.5 * h), order), n, k, k2);
        for (int j = 0; j < 6; j++) z[j] = y[j] + 0.5 * h * k2[j];
        rates(z, fmin(rate * (t + 0.5 * h), order), n, k, k3);
        for (int j = 0; j < 6; j++) z[j] = y[j] + h * k3[j];
        rates(z, fmin(rate * (t + h), order), n, k, k4);
        for (int j = 0; j < 6; j++) y[j] += h / 6.0 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j]);
    }
    clock_gettime(CLOCK_MONOTONIC, &b);
    return (b.tv_sec - a.tv_sec) + 1e-9 * (b.tv_nsec - a.tv_nsec);
}
