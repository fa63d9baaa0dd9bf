/*
 * bsdftree: variable-resolution BSDFs in C.
 *
 *   bsdftree *b;
 *   char message[512];
 *   if (bsdftree_load("blinds.xml", 0, &b, message, sizeof message) != BSDFTREE_OK) { ... message ... }
 *   const bsdftree_band *visible = bsdftree_find_band(b, NULL);
 *   double f = bsdftree_eval(visible, incident, exitant);
 *   bsdftree_free(b);
 *
 * Directions are unit vectors double[3] that point AWAY from the surface, the incident one too. +Z is the front (the room), +Y is
 * up, X is right seen from the front. Which side the two directions lie on chooses the component. An absent transmission is the other
 * one with the directions swapped, an absent reflection is black. Values are [1/sr] WITHOUT a cosine, as in the file: multiply by
 * |cos theta| of the exitant direction to render.
 *
 * Everything is thread-safe after loading: any number of threads may use one bsdftree at the same time. There are no globals.
 * Tables for sampling are made when first needed and never change a result. Pointers that are not noted "or NULL" must be valid.
 *
 *   Radiance's BSDF library          here
 *   SDloadFile, SDfreeBSDF           bsdftree_load, bsdftree_free
 *   SDevalBSDF                       bsdftree_eval, bsdftree_eval_xyz
 *   SDsampBSDF                       bsdftree_sample, with its density: bsdftree_pdf; its colour: bsdftree_eval_xyz * |cos| / pdf
 *   SDdirectHemi                     bsdftree_hemispherical
 *   SDsizeBSDF                       bsdftree_projected_solid_angle, bsdftree_projected_solid_angle_range
 *   SDmultiSamp                      numbers of yours: stratified ones give stratified directions
 *   SDcacheFile, SDfreeCache         the bsdftree itself: load it once
 */
#ifndef BSDFTREE_H
#define BSDFTREE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A whole BSDF, and one of its spectral bands, which belongs to it. */
typedef struct bsdftree bsdftree;
typedef struct bsdftree_band bsdftree_band;

typedef enum bsdftree_status {
    BSDFTREE_OK = 0,
    BSDFTREE_ERROR_FILE = 1,     /* the file cannot be read */
    BSDFTREE_ERROR_FORMAT = 2,   /* it is no BSDF, or damaged */
    BSDFTREE_ERROR_ARGUMENT = 3, /* a NULL pointer, or a path that is not UTF-8 */
    BSDFTREE_ERROR_INTERNAL = 4  /* an error in this library: please report it */
} bsdftree_status;

/* What bsdftree_load does with a file that has something wrong which can be mended (0: refuses it). */
#define BSDFTREE_REPAIR 1u

/* Ramps in the leaves of trees instead of steps: what goes up and down between cells does so inside them, the mean over each leaf is
   kept. Values, samples, densities and totals fit together as before. Matrices and colour stay constant over their cells. */
#define BSDFTREE_SMOOTH 2u

/* Exitant sides that a query is about: that of the light, the other one, or both. */
typedef enum bsdftree_lobes {
    BSDFTREE_ALL = 0,
    BSDFTREE_REFLECTION = 1,
    BSDFTREE_TRANSMISSION = 2
} bsdftree_lobes;

typedef struct bsdftree_direction_sample {
    double exitant[3]; /* where the light goes; meaningless where pdf is 0 */
    double pdf;        /* density of exitant [1/sr of solid angle]; 0 where the BSDF is black */
    double weight;     /* BSDF * |cos theta| / pdf: the fraction of light that the sample stands for */
} bsdftree_direction_sample;

/* "0.1.0" */
const char *bsdftree_version(void);

/* Reads a BSDF file: Klems matrices or tensor trees, as WINDOW 6 XML or .bsdft, told apart by their first bytes. A raw .bsdft file is
   mapped, must not be changed while it is in use, and is verified by bsdftree_verify only. On success *out is the BSDF, to be freed; else it is NULL, and
   message (or NULL) holds at most size bytes of what is wrong, where, and what to do, ended by 0. */
bsdftree_status bsdftree_load(const char *path, unsigned flags, bsdftree **out, char *message, size_t size);

/* The same from the bytes of a file in memory, which need not outlive the call. */
bsdftree_status bsdftree_load_memory(const void *bytes, size_t n_bytes, unsigned flags, bsdftree **out, char *message,
                                     size_t size);

/* Looks through the values of a .bsdft file, which loading does not do; those of XML always are as they were written. Queries of a
   damaged file are safe, but their answers are worth nothing. */
bsdftree_status bsdftree_verify(const bsdftree *bsdf, char *message, size_t size);

/* Frees a BSDF (or NULL) and its bands. */
void bsdftree_free(bsdftree *bsdf);

/* The band of a name in any case, such as "Solar"; "Visible" if name is NULL. NULL if there is none. */
const bsdftree_band *bsdftree_find_band(const bsdftree *bsdf, const char *name);

/* BSDF [1/sr], no cosine; 0 where there is no component. */
double bsdftree_eval(const bsdftree_band *band, const double incident[3], const double exitant[3]);

/* BSDF as CIE X, Y, Z [1/sr], no cosine; equal numbers where there is no colour. */
void bsdftree_eval_xyz(const bsdftree_band *band, const double incident[3], const double exitant[3], double xyz[3]);

/* A direction in proportion to BSDF * |cos theta|, from a number in [0, 1). Stratified numbers give stratified directions. */
bsdftree_direction_sample bsdftree_sample(const bsdftree_band *band, const double incident[3], double u,
                                          bsdftree_lobes lobes);

/* The same from two numbers in [0, 1). */
bsdftree_direction_sample bsdftree_sample_2d(const bsdftree_band *band, const double incident[3], const double uv[2],
                                             bsdftree_lobes lobes);

/* Density [1/sr of solid angle] with which exitant is sampled. */
double bsdftree_pdf(const bsdftree_band *band, const double incident[3], const double exitant[3], bsdftree_lobes lobes);

/* Directional-hemispherical scattering: the fraction of light from incident that leaves. */
double bsdftree_hemispherical(const bsdftree_band *band, const double incident[3], bsdftree_lobes lobes);

/* Projected solid angle [sr] of the exitant cell of a pair; negative where there is no component. */
double bsdftree_projected_solid_angle(const bsdftree_band *band, const double incident[3], const double exitant[3]);

/* Smallest and largest projected solid angle [sr] of the exitant cells that incident meets; both negative if there is no component. */
void bsdftree_projected_solid_angle_range(const bsdftree_band *band, const double incident[3], bsdftree_lobes lobes,
                                          double range[2]);

/* Many at once, several times as fast: n directions are n * 3 numbers, one direction after the other. Results are those of the single
   calls to the bit. For n = 0 pointers may be NULL. */
void bsdftree_eval_many(const bsdftree_band *band, size_t n, const double *incident, const double *exitant, double *values);
void bsdftree_pdf_many(const bsdftree_band *band, size_t n, const double *incident, const double *exitant,
                       bsdftree_lobes lobes, double *densities);
void bsdftree_hemispherical_many(const bsdftree_band *band, size_t n, const double *incident, bsdftree_lobes lobes,
                                 double *totals);
void bsdftree_projected_solid_angle_many(const bsdftree_band *band, size_t n, const double *incident, const double *exitant,
                                         double *angles);
/* v may be NULL. */
void bsdftree_sample_many(const bsdftree_band *band, size_t n, const double *incident, const double *u, const double *v,
                          bsdftree_lobes lobes, bsdftree_direction_sample *samples);

#ifdef __cplusplus
}
#endif

#endif
