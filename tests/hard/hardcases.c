// SPDX-License-Identifier: Apache-2.0
/* The hard cases against plain forms in double, the largest error of each cell
 * printed. Status 1 when a cell is over its bar.
 *
 *   hardcases [FAMILY|families]   all families, one of them, or their names
 *
 * GLAREPP_TEST_QUICK leaves out GL and large cases. */
#include "hardcases.h"

#include "core/parallel.h"
#include "set_env.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int hard_quick;

// -- tables -------------------------------------------------------------------

static struct {
    const char *title;
    const struct hard_column *column;
    int at;             // column of the next cell
    int cells, over;    // of this table
    int all_cells, all_over;
} table;

/* The lines of a table are TAP's diagnostics under the tests' runner. */
static const char *mark(void)
{
    const char *const form = getenv("CMOCKA_MESSAGE_OUTPUT");
    return form && strcmp(form, "TAP") == 0 ? "# " : "";
}

static void print_number(double v)
{
    if (v == 0.0)
        printf("0");
    else
        printf("%.1e", v);
}

void hard_table(const char *title, const char *unit,
                const struct hard_column *columns)
{
    table.title = title;
    table.column = columns;
    table.at = table.cells = table.over = 0;
    printf("%s\n%s**%s**: %s\n%s\n%s| case |", mark(), mark(), title, unit,
           mark(), mark());
    for (int i = 0; columns[i].name; i++)
        printf(" %s |", columns[i].name);
    printf("\n%s|---|", mark());
    for (int i = 0; columns[i].name; i++)
        printf("---|");
    printf("\n");
}

void hard_row(const char *name)
{
    table.at = 0;
    printf("%s| %s |", mark(), name);
}

static void end_cell(void)
{
    table.at++;
    if (!table.column[table.at].name)
        printf("\n");
    fflush(stdout);
}

void hard_cell(double error, double bar)
{
    const double usual = table.column[table.at].bar;
    const int over = !(error <= bar);
    printf(over ? " **" : " ");
    print_number(error);
    if (isinf(bar)) {
        printf(isinf(usual) ? "" : " (no bar)");
    } else if (bar != usual && (over || error != 0.0)) {
        printf(" (≤ ");
        print_number(bar);
        printf(")");
    }
    printf(over ? " OVER** |" : " |");
    table.cells++;
    table.over += over;
    end_cell();
}

void hard_refused(void)
{
    printf(" refused |");
    table.cells++;
    end_cell();
}

void hard_cell_if(bool ran, double error, double bar)
{
    if (ran) {
        hard_cell(error, bar);
        return;
    }
    printf(" – |");
    end_cell();
}

void hard_table_end(void)
{
    hard_row("**bar**");
    for (int i = 0; table.column[i].name; i++) {
        if (isinf(table.column[i].bar))
            printf(" its own |");
        else if (table.column[i].bar == 0.0)
            printf(" **0** |");
        else
            printf(" **≤ %.3g** |", table.column[i].bar);
    }
    printf("\n");
    table.all_cells += table.cells;
    table.all_over += table.over;
    if (*mark() && table.cells)
        printf("%sok - %s: %d cells, %d over their bar\n",
               table.over ? "not " : "", table.title, table.cells, table.over);
}

/* The last line. Returns how many cells were over their bar. */
static int count_cells(void)
{
    printf("%s\n%scells: %d, over their bar: %d\n", mark(), mark(),
           table.all_cells, table.all_over);
    return table.all_over;
}

// -- cases --------------------------------------------------------------------

_Noreturn void hard_die(const char *what, const char *why)
{
    fflush(stdout);
    fprintf(stderr, "hardcases: %s: %s\n", what, why);
    exit(2);
}

void hard_thread_rows(int columns, int rows, hard_picked picked,
                      hard_count_differing count)
{
    double differ[16];
    if (columns > 16)
        hard_die("a table", "has more columns than hard_thread_rows() counts");
    for (int t = 0; t < HARD_THREADS; t++) {
        char name[32];
        snprintf(name, sizeof name, "%d threads", hard_threads[t]);
        memset(differ, 0, sizeof differ);
        for (int row = 0; row < rows; row++) {
            if (picked(row))
                count(row, hard_threads[t], differ);
        }
        hard_row(name);
        for (int i = 0; i < columns; i++)
            hard_cell_if(!isnan(differ[i]), differ[i], 0.0);
    }
}

void hard_thread_table(const char *title, const char *unit,
                       const struct hard_column *columns, int rows,
                       hard_picked picked, hard_count_differing count)
{
    struct hard_column same[17] = {{NULL, 0}};
    int n = 0;
    for (; columns[n].name; n++)
        same[n].name = columns[n].name;
    hard_table(title, unit, same);
    hard_thread_rows(n, rows, picked, count);
    hard_table_end();
}

uint8_t *hard_read_bytes(const char *path, size_t *size)
{
    FILE *const f = fopen(path, "rb");
    if (!f || fseek(f, 0, SEEK_END))
        hard_die(path, "cannot be read");
    *size = (size_t) ftell(f);
    rewind(f);
    uint8_t *const bytes = scene_alloc(*size + 1, 1);
    if (fread(bytes, 1, *size, f) != *size)
        hard_die(path, "cannot be read");
    fclose(f);
    return bytes;
}

/* The build puts this program one folder below the OpenImageIO bridge. */
static void find_bridge(void)
{
    char self[4096] = "", folder[4200];
    if (readlink("/proc/self/exe", self, sizeof self - 1) < 0)
        hard_die("/proc/self/exe", "cannot be read");
    *strrchr(self, '/') = '\0';
    snprintf(folder, sizeof folder, "%s/..", self);
    if (set_env(getenv("GLAREPP_BRIDGES") ? NULL : "GLAREPP_BRIDGES", folder))
        hard_die("setenv", "no memory");
}

int main(int argc, char *argv[])
{
    static const struct {
        const char *name;
        void (*run)(void);
    } families[] = {
        {"glare", hard_glare}, {"field", hard_field}, {"slide", hard_slide},
        {"tone", hard_tone}, {"sun", hard_sun}, {"files", hard_files},
        {"formats", hard_other_files}, {"scenes", hard_scenes},
    };
    gp_environment_set_gl(gp_threads());
    hard_quick = getenv("GLAREPP_TEST_QUICK") != NULL;
    const size_t n = sizeof families / sizeof *families;
    if (argc > 1 && strcmp(argv[1], "families") == 0) {
        for (size_t i = 0; i < n; i++)
            puts(families[i].name);
        return 0;
    }
    find_bridge();
    for (size_t i = 0; i < n; i++) {
        if (argc < 2 || strcmp(argv[1], families[i].name) == 0)
            families[i].run();
    }
    return count_cells() ? 1 : 0;
}
