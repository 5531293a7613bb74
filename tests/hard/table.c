#include "table.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

int hard_count(void)
{
    printf("%s\n%scells: %d, over their bar: %d\n", mark(), mark(),
           table.all_cells, table.all_over);
    return table.all_over;
}
