# SPDX-License-Identifier: Apache-2.0
# Makes the man page: puts the rows that `glarepp --help-table` prints (first
# file) as mdoc in the place of the lines @OPTIONS@, @BENCH@, @MODELS@ and
# @EXIT@ of the page (second file).
BEGIN { FS = "\t" }

function put(line) { made[part] = made[part] line "\n" }

# Puts text as lines of at most 80 characters that hold no roff commands.
function put_text(text,    n, words, i, k, c, line, column) {
    n = split(text, words, " ")
    for (i = 1; i <= n; i++) {
        if (column && column + length(words[i]) > 70) { # room for escapes
            put(line)
            line = ""
            column = 0
        } else if (column)
            line = line " "
        if (words[i] ~ /^[.']/)
            line = line "\\&"
        for (k = 1; k <= length(words[i]); k++) {
            c = substr(words[i], k, 1)
            line = line (c == "\\" ? "\\e" : substr(words[i], k, 2) ~ /^-[0-9]/ ? "\\-" : c)
        }
        column += length(words[i]) + 1
    }
    put(line)
}

# Opens a list below an item, and closes those that are open from `level` on.
function open_list(width) { put(".Bl -tag -width Ds" width); depth++ }
function close_lists(level) { for (; depth > level; depth--) put(".El") }

NR != FNR && /^@[A-Z]+@$/ {
    if (!($0 in made)) {
        print FILENAME ": nothing to put for " $0 > "/dev/stderr"
        exit 1
    }
    printf "%s", made[$0]
    next
}
NR != FNR { print; next }

$1 == "group" {
    part = "@OPTIONS@"
    close_lists(0)
    put(".Ss " $2 "\n.Dl " $3)
    open_list("")
}
$1 == "option" {
    close_lists(1)
    put(".It " ($3 ? "Fl " $3 " , " : "") "Fl \\-" $2 ($4 ? " Ar " $4 : ""))
    put_text($6 ".")
    if ($7 ~ / main / && $7 ~ / bench /) { # options that both take
        part = "@BENCH@"
        if (both)
            put(".Fl \\-" both " ,")
        both = $2
        part = "@OPTIONS@"
    }
}
$1 == "value" {
    if (depth == 1)
        open_list(" -compact")
    put(".It Cm " $2)
    if ($3)
        put_text($3)
}
$1 == "model" {
    close_lists(0)
    part = "@MODELS@"
    put(".It Cm " $2)
    put_text($3)
    open_list(" -compact")
}
$1 == "key" {
    put(".It Cm " $2)
    gsub(/ /, ", ", $3)
    put_text($4 ($3 ? " (" $3 ")" : ""))
}
$1 == "status" {
    close_lists(0)
    part = "@EXIT@"
    put(".It " $2 "\n" $3 ".")
}
$1 == "status" && !ended++ { made["@BENCH@"] = made["@BENCH@"] "and\n.Fl \\-" both " .\n" }
