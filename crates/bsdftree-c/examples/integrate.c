/* Integrates a BSDF over the exitant sphere in two ways and compares both with its own total: by uniform directions and by its own samples.
 *
 *   cc integrate.c $(pkg-config --cflags --libs bsdftree) -lm -o integrate && ./integrate blinds.xml
 */
#include <bsdftree.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { N = 1 << 18 };

/* Two numbers of the R2 sequence (M. Roberts, 2018). */
static void evenly(size_t k, double uv[2])
{
    uv[0] = fmod(0.5 + 0.7548776662466927 * (double)k, 1.0);
    uv[1] = fmod(0.5 + 0.5698402909980532 * (double)k, 1.0);
}

/* A direction uniform in projected solid angle on both sides, so that each stands for 2 pi / N [sr of projected solid angle]. */
static void direction(const double uv[2], double d[3])
{
    const double pi = 3.14159265358979323846;
    const double r2 = fmod(2.0 * uv[0], 1.0), r = sqrt(r2), phi = 2.0 * pi * uv[1];
    d[0] = r * cos(phi);
    d[1] = r * sin(phi);
    d[2] = (uv[0] < 0.5 ? 1.0 : -1.0) * sqrt(1.0 - r2);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: %s BSDF.xml\n", argv[0]);
        return 2;
    }
    bsdftree *bsdf;
    char message[1024];
    if (bsdftree_load(argv[1], 0, &bsdf, message, sizeof message) != BSDFTREE_OK) {
        fprintf(stderr, "%s\n", message);
        return 1;
    }
    const bsdftree_band *band = bsdftree_find_band(bsdf, NULL);
    if (!band) {
        fprintf(stderr, "%s has no band Visible\n", argv[1]);
        return 1;
    }
    const double pi = 3.14159265358979323846;
    double *exitant = malloc(3 * N * sizeof *exitant), *incident = malloc(3 * N * sizeof *incident);
    double *value = malloc(N * sizeof *value);
    if (!exitant || !incident || !value)
        return 1;
    int wrong = 0;
    printf("bsdftree %s: %s\n%8s %10s %10s %10s\n", bsdftree_version(), argv[1], "theta", "total", "integral", "samples");
    for (int theta = -75; theta <= 75; theta += 30) {
        const double t = theta * pi / 180.0, side = theta < 0 ? -1.0 : 1.0;
        const double from[3] = {sin(fabs(t)), 0.0, side * cos(t)};
        for (size_t k = 0; k < N; k++) {
            double uv[2];
            evenly(k, uv);
            direction(uv, exitant + 3 * k);
            for (int c = 0; c < 3; c++)
                incident[3 * k + c] = from[c];
        }
        bsdftree_eval_many(band, N, incident, exitant, value);
        double integral = 0.0, sampled = 0.0;
        for (size_t k = 0; k < N; k++)
            integral += value[k] * 2.0 * pi / N;
        for (size_t k = 0; k < 1000; k++) {
            const bsdftree_direction_sample s = bsdftree_sample(band, from, (k + 0.5) / 1000.0, BSDFTREE_ALL);
            if (s.pdf > 0.0)
                sampled += bsdftree_eval(band, from, s.exitant) * fabs(s.exitant[2]) / s.pdf / 1000.0;
        }
        const double total = bsdftree_hemispherical(band, from, BSDFTREE_ALL);
        printf("%8d %10.5f %10.5f %10.5f\n", theta, total, integral, sampled);
        wrong |= fabs(integral - total) > 0.01 * fmax(total, 0.1) || fabs(sampled - total) > 1e-3 * fmax(total, 0.1);
    }
    free(exitant);
    free(incident);
    free(value);
    bsdftree_free(bsdf);
    return wrong;
}
