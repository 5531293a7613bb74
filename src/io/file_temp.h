/* The temporary files that outputs are written as, and signals.
 *
 * A target's temporary file lies in its folder as .NAME.PID.tmp; where that
 * name is taken (by a run with the same number in another container or on
 * another machine, or by one that was killed) as .NAME.PID-1.tmp, and so on. A
 * file that another process made is never touched.
 */
#ifndef GP_IO_FILE_TEMP_H
#define GP_IO_FILE_TEMP_H

/* One temporary file; all zero: none. */
struct gp_temp {
    char *name; // owned; gone after gp_temp_end()
    int live;   // where a signal finds the name, or -1
};

/* Makes the temporary file of `target`, open for writing; its descriptor, or
 * -1 with errno set and nothing made. */
int gp_temp_make(struct gp_temp *temp, const char *target);

/* Renames it to `target`, or removes it when that is NULL; 0, or -1 with
 * errno set: then it stays to be removed. Does nothing where there is none. */
int gp_temp_end(struct gp_temp *temp, const char *target);

/* Removes the temporary files of the whole process, which is to end at once:
 * every thread that makes or gives up another waits from then on. Safe in a
 * signal's handler. */
void gp_temp_remove_all(void);

/* Never returns once these are being removed: what goes wrong from then on is
 * that one's doing and not worth a line. */
void gp_temp_wait(void);

/* Call once at start: signals that end a process, and that may be caught (from
 * the terminal, a batch system or a timer), remove the temporary files that are
 * under way and then end it as they would have; a signal that the parent set to
 * be ignored stays ignored. SIGPIPE is ignored from then on, so that a closed
 * pipe is GP_ERR_IO and not a silent end. */
void gp_temp_cleanup_on_signal(void);

#endif
