// SPDX-License-Identifier: Apache-2.0
/* Scenes that must be refused: each file is one line with its name and the
 * status of bad data, and nothing is kept. */
#include "hardcases.h"

#include "gltf_wrong.h"

#define EITHER GP_ERR_FRAMES // no reader's status

static const float places[9] = {0, 0, 0, 1, 0, 0, 0, 2, 0};

/* Counts faults of reading a file: one that must be read or not, by `status`;
 * EITHER: either. */
static int count_faults(const char *file, gp_status status, const char *part)
{
    struct gp_scene s = {.objects = 77};
    kept_clear();
    const gp_status st = gp_scene_read(&kept_log, file, GLAREPP_UP_Y, NULL, &s);
    int faults = status != EITHER && st != status;
    if (st == GP_OK) {
        for (int i = 0; i < s.objects; i++)
            faults += !isfinite(s.object[i].radius);
        gp_scene_free(&s);
        return faults;
    }
    faults += st != GP_ERR_DATA && st != GP_ERR_IO;
    faults += kept_errors != 1 ||
              !strstr(kept_line, st == GP_ERR_IO ? part : file) ||
              !strstr(kept_line, part) || strchr(kept_line, '\n');
    return faults + (s.objects != 77);
}

static void print_row(const char *name, int faults)
{
    hard_row(name);
    if (faults)
        hard_cell(faults, 0.0);
    else
        hard_refused();
}

/* A file cut off at each of its bytes, and one with each of them turned. */
static void print_bytes(void)
{
    size_t size;
    int cut = 0, turned = 0;
    char whole[sizeof path];
    snprintf(whole, sizeof whole, "%s",
             gm_write_glb(GM_GLB_JSON, places, 36, 0));
    uint8_t *const bytes = hard_read_bytes(whole, &size);
    cut += count_faults(whole, GP_OK, "");
    for (size_t i = 0; i < size; i++) {
        cut += count_faults(gm_write_bytes("a.glb", bytes, i), GP_ERR_DATA, "");
        bytes[i] ^= 0xff;
        turned += count_faults(gm_write_bytes("a.glb", bytes, size),
                               EITHER, "");
        bytes[i] ^= 0xff;
    }
    free(bytes);
    print_row("cut off at each byte", cut);
    hard_row("each byte turned");
    hard_cell(turned, 0.0);
}

void hard_broken(void)
{
    static const struct hard_column columns[] = {{"faults", 0}, {NULL, 0}};
    if (make_folder(NULL))
        hard_die("a folder", "cannot be made");
    hard_table("Broken scenes", "refused by one line that names the file, with "
                                "status 4 (3 for a file that is absent); bytes "
                                "turned: or read", columns);
    for (size_t i = 0; i < COUNT(gltf_wrong); i++)
        print_row(gltf_wrong[i].name,
                  count_faults(gm_write("%s", gltf_wrong[i].json), GP_ERR_DATA,
                               gltf_wrong[i].part));
    print_row("no .bin beside it",
              count_faults(gm_write("'buffers': [{'byteLength': 1, "
                                    "'uri': 'no.bin'}]"), GP_ERR_IO, "no.bin"));
    print_bytes();
    hard_table_end();
    if (remove_folder(NULL))
        hard_die(folder, "cannot be removed");
}
