# Puts the parts that `glarepp --help-man` prints (first file, each after a
# line @NAME@) where the page (second file) has the same line.
NR == FNR {
    if (/^@[A-Z]+@$/)
        part = $0
    else
        text[part] = text[part] $0 "\n"
    next
}
/^@[A-Z]+@$/ {
    if (!($0 in text)) {
        print FILENAME ": nothing to put for " $0 > "/dev/stderr"
        exit 1
    }
    printf "%s", text[$0]
    next
}
{ print }
