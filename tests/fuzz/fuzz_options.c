// SPDX-License-Identifier: Apache-2.0
/* The command line, a word a line. */
#include "cli/options.h"
#include "harness.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_WORDS = 256 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static char program[] = "glarepp";
    char *argv[MOST_WORDS + 2] = {program};
    int argc = 1;
    struct gp_settings s;
    char *const text = malloc(size + 1);
    if (!text)
        return 0;
    memcpy(text, data, size);
    text[size] = '\0';
    char *rest = text;
    while (rest && argc <= MOST_WORDS)
        argv[argc++] = strsep(&rest, "\n");
    fuzz_begin();
    fuzz_line(gp_options_parse(&fuzz_log, argc, argv, &s));
    gp_settings_free(&s);
    fuzz_end(FUZZ_FIXED);
    free(text);
    return 0;
}
