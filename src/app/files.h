/* What a run writes, held against itself and against what it reads, before the
 * first file is opened: no output may replace a file that is read, nor another
 * output.
 *
 * Files are told apart as files and not by their names: those that are there
 * by device and inode, those that are not by their folder's and the name in it.
 * So links, ./ and folders with two names do not hide anything. What is no
 * regular file (pipes, devices) loses nothing by being written and may be given
 * any number of times. So may descriptors (stdout, /dev/fd/N), whatever they
 * stand for, but not for a file that is read; of `-` there is one.
 *
 * All outputs come first, then gp_files_settle(), then what is read. An output
 * costs one lstat() (and its folder one stat()), an input one stat(), and none
 * at all where no output is there yet. */
#ifndef GP_APP_FILES_H
#define GP_APP_FILES_H

#include "app/settings.h"
#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

/* A file that is written, and whose it is. */
struct gp_file_id {
    dev_t device;
    ino_t node;      // the file's, or its folder's
    uint64_t tail;   // of the name in the folder; 0: the file is there
    int role, item;  // the owner's, role >= 0; role < 0: a file of an option
    bool open;       // by a descriptor that was given: others may have it too
};

/* Who writes, for messages. */
struct gp_file_owner {
    char *name;        // as written; from malloc, NULL: memory is full
    const char *what;  // "--hdr"
    const char *as;    // its value, which may be a pattern
    const char *of;    // input that it is made of; NULL: goes without saying
    const char *view;  // of that input, or NULL
};

/* A folder that was looked at. */
struct gp_file_folder {
    char *path; // owned
    dev_t device;
    ino_t node;
    uint64_t tail; // of folders that are still to be made; start of the hash
};
enum { GP_FILE_FOLDERS = 8 };

struct gp_files {
    const struct gp_log *log;
    const struct gp_settings *s;
    struct gp_file_owner (*owner)(const void *user,
                                  const struct gp_file_id *id);
    const void *user;
    struct gp_file_id *id; // owned
    size_t n, room;
    bool there;            // some output is there, and could be an input
    struct gp_file_folder folder[GP_FILE_FOLDERS];
    int folders;           // that were looked at, as often as it was
};

/* Starts with the files that options with plain names write.
 *
 *   s      borrowed until the end
 *   owner  says whose an entry of gp_files_write() is; NULL: there is none
 *   out    ends with gp_files_end(), also after a failure
 *
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_files_begin(
    const struct gp_log *log, const struct gp_settings *s,
    struct gp_file_owner (*owner)(const void *user,
                                  const struct gp_file_id *id),
    const void *user, struct gp_files *out);

/* Adds an output. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_files_write(struct gp_files *f, const char *path,
                                       int role, int item);

/* All outputs are there: holds them against each other, and against the files
 * that options with plain names read.
 * Errors: GP_ERR_USAGE names the first that comes twice, or is read. */
GP_MUST_CHECK gp_status gp_files_settle(struct gp_files *f);

/* Holds the outputs against a file that is read; one that is not there loses
 * nothing. `-` is stdin.
 *   what  it is: "input"
 * Errors: GP_ERR_USAGE it would be replaced. */
GP_MUST_CHECK gp_status gp_files_read(const struct gp_files *f,
                                      const char *what, const char *path);

void gp_files_end(struct gp_files *f);

#endif
