// SPDX-License-Identifier: Apache-2.0
/* cli/machine.c: limits of control groups, in trees made here. */
#include "unit.h"
#include "cli/machine.h"
#include "folder.h"

#include <sys/stat.h>

enum { FILES = 4 };

/* Writes a file below the folder, with the folders that it is in. */
static void put_file(const char *root, const char *name, const char *text)
{
    char at[512];
    snprintf(at, sizeof at, "%s/%s", root, name);
    for (char *c = at + strlen(root); (c = strchr(c + 1, '/'));) {
        *c = '\0';
        mkdir(at, 0777);
        *c = '/';
    }
    FILE *const f = fopen(at, "w");
    assert_non_null(f);
    fputs(text, f);
    fclose(f);
}

#define V1 "sys/fs/cgroup/memory"
#define V2 "sys/fs/cgroup"
#define NO_LIMIT "9223372036854771712\n" // of v1
#define MOST SIZE_MAX // what the machine has

static void least_limit_of_the_groups(void **state)
{
    static const struct {
        const char *groups; // /proc/self/cgroup; NULL: no such file
        struct {
            const char *name, *text;
        } file[FILES];
        size_t want;
    } row[] = {
        {NULL, {{V2 "/memory.max", "5000\n"}}, MOST},
        {"0::/\n", {{V2 "/memory.max", "5000\n"}}, 5000}, // a container
        {"0::/\n", {{0}}, MOST},
        {"0::/a/b\n", {{V2 "/a/b/memory.max", "max\n"},
                       {V2 "/a/memory.max", "7000\n"}}, 7000},
        {"0::/a/b\n", {{V2 "/a/b/memory.max", "6000\n"},
                       {V2 "/a/memory.max", "7000\n"}}, 6000},
        {"0::/a/b\n", {{V2 "/a/b/memory.max", "8000\n"},
                       {V2 "/a/memory.max", "7000\n"}}, 7000},
        {"0::/a/b\n", {{V2 "/a/c/memory.max", "1\n"}}, MOST},
        // Slurm: the job has the limit, its steps none
        {"9:name=systemd:/\n4:memory:/slurm/uid_0/job_7/step_0/task_0\n0::/\n",
         {{V1 "/slurm/uid_0/job_7/step_0/task_0/memory.limit_in_bytes",
           NO_LIMIT},
          {V1 "/slurm/uid_0/job_7/step_0/memory.limit_in_bytes", "9000\n"},
          {V1 "/slurm/uid_0/job_7/memory.limit_in_bytes", "4000\n"},
          {V1 "/memory.limit_in_bytes", NO_LIMIT}}, 4000},
        // Docker of v1: the path is the host's, the mount the container's
        {"4:cpu,memory:/docker/0123\n", {{V1 "/memory.limit_in_bytes",
                                          "3000\n"}}, 3000},
        {"4:memory,hugetlb:/x\n0::/y\n", {{V1 "/x/memory.limit_in_bytes",
                                           "3000\n"},
                                          {V2 "/y/memory.max", "2000\n"}},
         2000},
        // nothing that is a limit
        {"0::/a\n", {{V2 "/a/memory.max", "0\n"}}, MOST},
        {"0::/a\n", {{V2 "/a/memory.max", ""}}, MOST},
        {"0::/a\n", {{V2 "/a/memory.max", "99999999999999999999999\n"}}, MOST},
        {"0\n\n:\n::\n0::", {{V2 "/memory.max", "5000\n"}}, 5000},
        {"0::/../..\n", {{V2 "/memory.max", "5000\n"}}, 5000},
    };
    const size_t machine = gp_memory_limit(folder);
    assert_true(machine > (size_t) 1 << 24);
    for (size_t i = 0; i < COUNT(row); i++) {
        char root[280];
        snprintf(root, sizeof root, "%s/%zu", folder, i);
        mkdir(root, 0777);
        if (row[i].groups)
            put_file(root, "proc/self/cgroup", row[i].groups);
        for (int k = 0; k < FILES && row[i].file[k].name; k++)
            put_file(root, row[i].file[k].name, row[i].file[k].text);
        const size_t got = gp_memory_limit(root);
        const size_t want = row[i].want < MOST ? row[i].want : machine;
        if (got != want)
            fail_msg("row %zu: %zu, wanted %zu", i, got, want);
    }
}

SUITE_OF(machine, make_folder, remove_folder, least_limit_of_the_groups)
