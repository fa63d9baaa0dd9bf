/* Everything in bsdftree.h, also from many threads: cc interface.c -lbsdftree -lpthread -lm; interface GOOD.xml BAD.xml */
#include <bsdftree.h>

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(claim)                                                          \
    do {                                                                      \
        if (!(claim)) {                                                       \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #claim); \
            exit(1);                                                          \
        }                                                                     \
    } while (0)

enum { N = 5000, THREADS = 8 };

static const bsdftree_band *band;
/* Within what relative distance densities of samples and of directions agree: ramps see the rounding of a direction. */
static double agreement = 1e-12;
static double incident[3 * N], exitant[3 * N], u[N], v[N];

static double number(unsigned long long *state)
{
    *state = *state * 6364136223846793005ULL + 1442695040888963407ULL;
    return (double)(*state >> 11) / 9007199254740992.0;
}

static void direction(unsigned long long *state, double d[3])
{
    const double z = 2.0 * number(state) - 1.0, phi = 6.283185307179586 * number(state), r = sqrt(1.0 - z * z);
    d[0] = r * cos(phi);
    d[1] = r * sin(phi);
    d[2] = z;
}

/* All queries; the sum of their answers. */
static double queries(void)
{
    double sum = 0.0, range[2], xyz[3];
    for (int k = 0; k < N; k++) {
        const double *i = incident + 3 * k, *o = exitant + 3 * k;
        const bsdftree_lobes lobes = (bsdftree_lobes)(k % 3);
        const double f = bsdftree_eval(band, i, o);
        bsdftree_eval_xyz(band, i, o, xyz);
        CHECK(f >= 0.0 && xyz[1] == f);
        const bsdftree_direction_sample s = bsdftree_sample(band, i, u[k], lobes);
        const double uv[2] = {u[k], v[k]};
        const bsdftree_direction_sample t = bsdftree_sample_2d(band, i, uv, lobes);
        const double total = bsdftree_hemispherical(band, i, lobes);
        CHECK(s.pdf == 0.0 || (s.weight == total && fabs(bsdftree_pdf(band, i, s.exitant, lobes) / s.pdf - 1.0) < agreement));
        bsdftree_projected_solid_angle_range(band, i, lobes, range);
        const double angle = bsdftree_projected_solid_angle(band, i, o);
        CHECK(range[0] <= range[1]);
        sum += f + xyz[0] + s.pdf + t.pdf + total + angle + range[0] + bsdftree_pdf(band, i, o, lobes);
    }
    return sum;
}

static void *thread(void *out)
{
    *(double *)out = queries();
    return NULL;
}

int main(int argc, char **argv)
{
    CHECK(argc == 3);
    char message[400];
    bsdftree *bsdf = (bsdftree *)message;
    CHECK(strlen(bsdftree_version()) >= 5);
    CHECK(bsdftree_load("no such file.xml", 0, &bsdf, message, sizeof message) == BSDFTREE_ERROR_FILE && !bsdf);
    CHECK(strstr(message, "no such file.xml"));
    CHECK(bsdftree_load(argv[2], 0, &bsdf, message, sizeof message) == BSDFTREE_ERROR_FORMAT && !bsdf && *message);
    char small[8];
    memset(small, 'x', sizeof small);
    CHECK(bsdftree_load(argv[2], 0, &bsdf, small, 4) == BSDFTREE_ERROR_FORMAT && strlen(small) == 3 && small[4] == 'x');
    CHECK(bsdftree_load(argv[2], 0, &bsdf, NULL, 0) == BSDFTREE_ERROR_FORMAT);
    CHECK(bsdftree_load(NULL, 0, &bsdf, message, sizeof message) == BSDFTREE_ERROR_ARGUMENT);
    CHECK(bsdftree_load("\xff", 0, &bsdf, message, sizeof message) == BSDFTREE_ERROR_ARGUMENT);
    CHECK(bsdftree_load(argv[1], 0, NULL, message, sizeof message) == BSDFTREE_ERROR_ARGUMENT);
    CHECK(bsdftree_load_memory("<no", 3, BSDFTREE_REPAIR, &bsdf, message, sizeof message) == BSDFTREE_ERROR_FORMAT);
    bsdftree_free(NULL);

    FILE *file = fopen(argv[1], "rb");
    CHECK(file);
    static char bytes[1 << 24];
    const size_t n_bytes = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    CHECK(bsdftree_load_memory(bytes, n_bytes, 0, &bsdf, message, sizeof message) == BSDFTREE_OK && !*message);
    CHECK(bsdftree_find_band(bsdf, "VISIBLE") == bsdftree_find_band(bsdf, NULL));
    CHECK(!bsdftree_find_band(bsdf, "Infrared of no file"));
    bsdftree_free(bsdf);

    CHECK(bsdftree_load(argv[1], 0, &bsdf, message, sizeof message) == BSDFTREE_OK);
    band = bsdftree_find_band(bsdf, NULL);
    CHECK(band);
    unsigned long long state = 1;
    for (int k = 0; k < N; k++) {
        direction(&state, incident + 3 * k);
        direction(&state, exitant + 3 * k);
        u[k] = number(&state);
        v[k] = number(&state);
    }
    /* Threads first, so that they make the tables together. */
    pthread_t threads[THREADS];
    double sums[THREADS];
    for (int k = 0; k < THREADS; k++)
        CHECK(pthread_create(threads + k, NULL, thread, sums + k) == 0);
    for (int k = 0; k < THREADS; k++)
        CHECK(pthread_join(threads[k], NULL) == 0);
    const double sum = queries();
    for (int k = 0; k < THREADS; k++)
        CHECK(sums[k] == sum);

    static double values[N], densities[N], totals[N], angles[N];
    static bsdftree_direction_sample samples[N];
    bsdftree_eval_many(band, N, incident, exitant, values);
    bsdftree_pdf_many(band, N, incident, exitant, BSDFTREE_ALL, densities);
    bsdftree_hemispherical_many(band, N, incident, BSDFTREE_TRANSMISSION, totals);
    bsdftree_projected_solid_angle_many(band, N, incident, exitant, angles);
    for (int twice = 0; twice < 2; twice++) {
        bsdftree_sample_many(band, N, incident, u, twice ? v : NULL, BSDFTREE_ALL, samples);
        for (int k = 0; k < N; k++) {
            const double uv[2] = {u[k], v[k]}, *i = incident + 3 * k;
            const bsdftree_direction_sample s =
                twice ? bsdftree_sample_2d(band, i, uv, BSDFTREE_ALL) : bsdftree_sample(band, i, u[k], BSDFTREE_ALL);
            CHECK(memcmp(&s, samples + k, sizeof s) == 0);
        }
    }
    for (int k = 0; k < N; k++) {
        const double *i = incident + 3 * k, *o = exitant + 3 * k;
        CHECK(values[k] == bsdftree_eval(band, i, o));
        CHECK(densities[k] == bsdftree_pdf(band, i, o, BSDFTREE_ALL));
        CHECK(totals[k] == bsdftree_hemispherical(band, i, BSDFTREE_TRANSMISSION));
        CHECK(angles[k] == bsdftree_projected_solid_angle(band, i, o));
    }
    CHECK(bsdftree_verify(bsdf, NULL, 0) == BSDFTREE_OK);
    bsdftree_eval_many(band, 0, NULL, NULL, NULL);
    bsdftree_sample_many(band, 0, NULL, NULL, NULL, BSDFTREE_ALL, NULL);
    bsdftree_free(bsdf);

    CHECK(bsdftree_load(argv[1], BSDFTREE_SMOOTH, &bsdf, message, sizeof message) == BSDFTREE_OK);
    band = bsdftree_find_band(bsdf, NULL);
    agreement = 1e-8;
    for (int k = 0; k < THREADS; k++)
        CHECK(pthread_create(threads + k, NULL, thread, sums + k) == 0);
    for (int k = 0; k < THREADS; k++)
        CHECK(pthread_join(threads[k], NULL) == 0);
    for (int k = 1; k < THREADS; k++)
        CHECK(sums[k] == sums[0]);
    CHECK(sums[0] > 0.0);
    bsdftree_free(bsdf);
    puts("all of bsdftree.h holds");
    return 0;
}
