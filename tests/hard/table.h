/* Tables of errors in markdown: a row a case, a column a way to compute it, in
 * each cell the largest error. A cell over its bar is marked and counted. */
#ifndef GP_TESTS_HARD_TABLE_H
#define GP_TESTS_HARD_TABLE_H

#include <stdbool.h>

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

/* The last line. Returns how many cells were over their bar. */
int hard_count(void);

#endif
