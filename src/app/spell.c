#include "app/spell.h"

#include <stdbool.h>
#include <string.h>

enum { LONGEST = 31 };

static int least(int a, int b)
{
    return a < b ? a : b;
}

int gp_edits(const char *word, size_t n, const char *name)
{
    const size_t m = strlen(name);
    int rows[3][LONGEST + 1]; // of the table, in turn
    if (n > LONGEST || m > LONGEST)
        return 99;
    for (size_t j = 0; j <= m; j++)
        rows[0][j] = (int) j;
    for (size_t i = 1; i <= n; i++) {
        int *const row = rows[i % 3];
        const int *const above = rows[(i - 1) % 3];
        row[0] = (int) i;
        for (size_t j = 1; j <= m; j++) {
            const bool same = word[i - 1] == name[j - 1];
            row[j] = least(above[j - 1] + !same,
                           least(above[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && word[i - 1] == name[j - 2] &&
                word[i - 2] == name[j - 1])
                row[j] = least(row[j], rows[(i - 2) % 3][j - 2] + 1);
        }
    }
    return rows[n % 3][m];
}

struct gp_nearest gp_nearest_to(const char *word, size_t length, int most)
{
    // a word of which half is wrong says nothing
    const int half = length < 64 ? (int) length / 2 : 0;
    return (struct gp_nearest) {
        .word = word, .length = length, .most = least(most, half),
    };
}

void gp_nearest_try(struct gp_nearest *search, const char *name)
{
    const int edits = gp_edits(search->word, search->length, name);
    if (search->name ? edits < search->most : edits <= search->most) {
        search->most = edits;
        search->name = name;
    }
}
