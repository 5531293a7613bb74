#include "core/nearest.h"

#include "core/minmax.h"

#include <stdbool.h>
#include <string.h>

struct gp_nearest gp_nearest_to(const char *word, size_t length, int most)
{
    // a word that is half wrong is no match
    const int half = length < 64 ? (int) length / 2 : 0;
    return (struct gp_nearest) {
        .word = word, .length = length, .most = gp_min(most, half),
    };
}

void gp_nearest_try(struct gp_nearest *search, const char *name)
{
    enum { LONGEST = 31 };
    const char *const word = search->word;
    const size_t n = search->length, m = strlen(name);
    int rows[3][LONGEST + 1]; // the last three of the table of distances
    if (n > LONGEST || m > LONGEST)
        return;
    for (size_t j = 0; j <= m; j++)
        rows[0][j] = (int) j;
    for (size_t i = 1; i <= n; i++) {
        int *const row = rows[i % 3];
        const int *const above = rows[(i - 1) % 3];
        row[0] = (int) i;
        for (size_t j = 1; j <= m; j++) {
            const bool same = word[i - 1] == name[j - 1];
            row[j] = gp_min(above[j - 1] + !same,
                            gp_min(above[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && word[i - 1] == name[j - 2] &&
                word[i - 2] == name[j - 1])
                row[j] = gp_min(row[j], rows[(i - 2) % 3][j - 2] + 1);
        }
    }
    const int edits = rows[n % 3][m];
    if (search->name ? edits < search->most : edits <= search->most) {
        search->most = edits;
        search->name = name;
    }
}
