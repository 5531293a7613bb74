// SPDX-License-Identifier: Apache-2.0
/* The targets without a fuzzer: feeds files, and the files of folders, to
 * LLVMFuzzerTestOneInput. Ends with "N inputs"; words with "-" are skipped,
 * because libFuzzer's own main takes its options so. */
#include "harness.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MOST_BYTES = 1 << 24, MOST_SECONDS = 60 };

static int inputs;

static void run_file(const char *path)
{
    FILE *const f = fopen(path, "rb");
    uint8_t *const all = malloc(MOST_BYTES);
    if (!f || !all) {
        fprintf(stderr, "%s: cannot read\n", path);
        exit(1);
    }
    const size_t size = fread(all, 1, MOST_BYTES, f);
    fclose(f);
    uint8_t *const data = malloc(size + !size); // its own end, for ASan
    if (!data)
        exit(1);
    memcpy(data, all, size);
    free(all);
    fprintf(stderr, "%s\n", path); // the last one named is the one that died
    alarm(MOST_SECONDS);
    LLVMFuzzerTestOneInput(data, size);
    alarm(0);
    free(data);
    inputs++;
}

static void run_target(const char *path)
{
    struct stat about;
    if (stat(path, &about) || !S_ISDIR(about.st_mode)) {
        run_file(path);
        return;
    }
    struct dirent **entry;
    const int n = scandir(path, &entry, NULL, alphasort);
    for (int i = 0; i < n; i++) {
        char name[4096];
        snprintf(name, sizeof name, "%s/%s", path, entry[i]->d_name);
        if (entry[i]->d_name[0] != '.')
            run_file(name);
        free(entry[i]);
    }
    if (n >= 0)
        free(entry);
}

int main(int argc, char *argv[])
{
    LLVMFuzzerInitialize(&argc, &argv);
    for (int i = 1; i < argc; i++) {
        if (argv[i][0] != '-')
            run_target(argv[i]);
    }
    fprintf(stderr, "%d inputs\n", inputs);
    return 0;
}
