// SPDX-License-Identifier: Apache-2.0
/* The families of hard cases, a table each: all rows of cases.h through every
 * engine, every tone curve, every sun method and every output format, those of
 * hostile.c through every engine of scenes. */
#ifndef GP_TESTS_HARD_HARDCASES_H
#define GP_TESTS_HARD_HARDCASES_H

#include "scenes.h"

#include <stdbool.h>

/* -- tables ----------------------------------------------------------------
 *
 * Of errors, in markdown: a row a case, a column a way to compute it, in each
 * cell the largest error. A cell over its bar is marked and counted. */

/* The bar of a cell for which nothing is promised. */
#define HARD_NO_BAR (1.0 / 0.0)

struct hard_column {
    const char *name;
    double bar; // of the cells whose own bar is not printed beside them
};

/* Starts a table. `columns` ends with a NULL name and stays until its end. */
void hard_table(const char *title, const char *unit,
                const struct hard_column *columns);
void hard_row(const char *name);

/* A cell, in the order of the columns: over its bar unless error <= bar. */
void hard_cell(double error, double bar);

/* A cell whose picture is refused, as it must be; it is counted. */
void hard_refused(void);

/* The same; `ran` is false where it cannot be measured here: not counted. */
void hard_cell_if(bool ran, double error, double bar);

/* Ends the table with the row of its bars; a TAP line where the tests' runner
 * asks for one. */
void hard_table_end(void);

/* -- cases ---------------------------------------------------------------- */

/* Rows that are run, in the table's order: all, or the quick ones. */
extern int hard_quick;

static inline int hard_is_run(const struct hard_case *h)
{
    return !hard_quick || hard_is_quick(h);
}

/* Numbers of threads that must give the bytes of one thread. */
static const int hard_threads[] = {2, 3, 8};
enum { HARD_THREADS = sizeof hard_threads / sizeof *hard_threads };

/* Rows that are run again with each of them: every seventh. */
static inline int hard_is_threaded(int i)
{
    return i % 7 == 3 && hard_is_run(&hard_cases[i]);
}

/* Adds a table's rows "N threads": for each number of threads, what count()
 * adds up over those of `rows` cases that are picked. It adds to differ[column]
 * how many things of that case are not those of one thread, or NAN where they
 * cannot be made here; the bar is 0. */
typedef int (*hard_picked)(int row);
typedef void (*hard_count_differing)(int row, int threads, double *differ);
void hard_thread_rows(int columns, int rows, hard_picked picked,
                      hard_count_differing count);

/* A table of nothing else. */
void hard_thread_table(const char *title, const char *unit,
                       const struct hard_column *columns, int rows,
                       hard_picked picked, hard_count_differing count);

/* The frame as it was made, not cleaned, and in f.lit that plus its exact
 * layer: what tone curves and files get, NaN and Inf included. The caller
 * frees it. */
static inline struct gp_image hard_lit(const struct hard_case *h)
{
    struct scene s = hard_scene(h);
    struct gp_image f = hard_frame(h);
    const size_t n = gp_image_pixels(&f);
    if (gp_planes_make(NULL, "lit", n, &f.lit))
        abort();
    for (size_t i = 0; i < 3 * n; i++)
        f.lit.c[i / n][i % n] = f.rgb.c[i / n][i % n] + (float) s.exact[i];
    scene_free(&s);
    return f;
}

/* The larger; what is no number is as wrong as can be. */
static inline double hard_worse(double a, double b)
{
    return b != b ? HARD_NO_BAR : fmax(a, b);
}

/* Ends the program: a case that cannot be run is no cell. */
_Noreturn void hard_die(const char *what, const char *why);

void hard_glare(void);
void hard_field(void);
void hard_slide(void);
void hard_tone(void);
void hard_sun(void);
void hard_files(void);
void hard_other_files(void);
void hard_scenes(void);

/* All bytes of a file; the caller frees. */
uint8_t *hard_read_bytes(const char *path, size_t *size);

/* glTF files that must be refused: the first table of hard_scenes(). */
void hard_broken(void);

#endif
