/* The folder for what later runs can use again. */
#ifndef GP_APP_CACHE_H
#define GP_APP_CACHE_H

/* Path of `name` in $XDG_CACHE_HOME/glarepp, or ~/.cache/glarepp where that
 * variable is unset or no absolute path (XDG Base Directory Specification
 * 0.8). Makes the folders. The caller owns the path (free()). NULL when there
 * is no such folder: the cache is a help, never a need. */
char *gp_cache_file(const char *name);

#endif
