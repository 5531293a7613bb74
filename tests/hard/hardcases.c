/* The hard cases against plain forms in double, the largest error of each cell
 * printed. Status 1 when a cell is over its bar.
 *
 *   hardcases [FAMILY|families]   all families, one of them, or their names
 *
 * GLAREPP_TEST_QUICK leaves out GL and large cases. */
#include "hardcases.h"

#include "core/parallel.h"
#include "set_env.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int hard_quick;

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
    return hard_count() ? 1 : 0;
}
