# SPDX-License-Identifier: Apache-2.0
# Makes C of page.html: its text before the line @DATA@, and after it. @STYLE@ and
# @SCRIPT@ lines become the files beside it, @STYLE-HASH@ and @SCRIPT-HASH@ the
# SHA-256 of them, given in hex as css and js, in base64.

function base64(hex,    digits, i, k, v, text)
{
    digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"
    hex = substr(hex, 1, 64) "00"
    for (i = 1; i <= 66; i += 3) {
        v = 0
        for (k = 0; k < 3; k++)
            v = 16 * v + index("0123456789abcdef", substr(hex, i + k, 1)) - 1
        text = text substr(digits, int(v / 64) + 1, 1) substr(digits, v % 64 + 1, 1)
    }
    return substr(text, 1, 43) "="
}

# (the text of an element begins at once: it has a hash)
function line(text)
{
    gsub(/[\\"?]/, "\\\\&", text)
    print "\"" text (text ~ /<(style|script( .*)?)>$/ ? "\"" : "\\n\"")
}

function file(name,    text)
{
    while ((getline text < name) > 0)
        line(text)
}

BEGIN {
    folder = "src/cli/page/page."
    print "#include \"cli/page/page.h\""
    print "const char gp_page_before[] ="
}

/^@STYLE@$/ { file(folder "css"); next }
/^@SCRIPT@$/ { file(folder "js"); next }
/^@DATA@$/ { print ";"; print "const char gp_page_after[] ="; next }
{
    gsub(/@STYLE-HASH@/, base64(css))
    gsub(/@SCRIPT-HASH@/, base64(js))
    line($0)
}
END { print ";" }
