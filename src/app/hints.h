/* What to do about a message of the library, with the option that helps: the
 * library's own text names none. */
#ifndef GP_APP_HINTS_H
#define GP_APP_HINTS_H

/* Returns words to put after the text of a message about that parameter: "; use
 * --engine fft", or ", or use --engine fft" where the text gives advice already.
 * "": none are needed. */
const char *gp_hint(const char *parameter, const char *text);

#endif
