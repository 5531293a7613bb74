# SPDX-License-Identifier: Apache-2.0
# Prints one row for each table of the hard cases: its cells, and the cell that
# is nearest to its bar. Cells without a bar count, but are not compared.

# Prints a number as the tables do.
function tidy(v)
{
    return v == 0 ? "0" : sprintf("%.3g", v)
}

function print_row(    c, r, n, bar, v, ratio, worst, at, text)
{
    worst = -1
    for (r = 1; r <= rows; r++) {
        for (c = 3; c < columns; c++) {
            text = cell[r, c]
            if (text !~ /[0-9a-z]/) # a dash: no cell
                continue
            cells++
            bar = limit[c]
            if (text ~ /≤/) {
                bar = text
                sub(/.*≤ /, "", bar)
                bar += 0
            }
            if (bar == "" || text ~ /refused/)
                continue
            gsub(/\*/, "", text)
            v = text + 0
            ratio = bar > 0 ? v / bar : v > 0 ? 1e300 : 0
            if (ratio > worst) {
                worst = ratio
                at = name[c] "," cell[r, 2]
                value = v
                of = bar
            }
        }
    }
    sub(/ +$/, "", at)
    printf "| %s | %d | %s | %s | %s |\n", title, cells, tidy(value), tidy(of),
        (worst > 0 ? at : "")
    cells = rows = columns = 0
}

BEGIN { # after a blank line, as the tables have
    FS = "|"
    print "\n| table | cells | nearest to its bar | bar | column, case |"
    print "|---|---|---|---|---|"
}
/^\*\*/ {
    title = $0
    sub(/^\*\*/, "", title)
    sub(/\*\*:.*/, "", title)
    next
}
/^\| case \|/ {
    columns = NF
    for (c = 3; c < NF; c++) {
        name[c] = $c
        gsub(/^ | $/, "", name[c])
    }
    next
}
/^\|---/ { next }
/^\| \*\*bar\*\* \|/ {
    for (c = 3; c < NF; c++) {
        limit[c] = $c
        gsub(/[^0-9.e+-]/, "", limit[c])
        if (limit[c] !~ /[0-9]/)
            limit[c] = ""
    }
    print_row()
    next
}
/^\|/ && columns {
    rows++
    for (c = 2; c < NF; c++)
        cell[rows, c] = $c
}
