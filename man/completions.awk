# SPDX-License-Identifier: Apache-2.0
# Makes the completions of a shell, bash, zsh or fish, of the rows that `glarepp
# --help-table` prints: awk -v shell=SHELL -f completions.awk TABLE
BEGIN { FS = "\t" }
$1 == "command" { commands[ncommands++] = $2 } # main is the first
$1 == "command" && $2 != "main" { space = space (space ? " " : "") $2 }
$1 == "topic" { topics = topics $2 " " }
$1 == "option" {
    name[++n] = $2; letter[n] = $3; arg[n] = $4; mark[n] = $5; text[n] = $6; in_[n] = $7
    file[n] = arg[n] ~ /FILE|CONFIG/
    named[n] = arg[n] ~ /=FILE$/
    model[n] = $2 ~ /^(kernel|check)$/ # a model and its keys, or a file
}
$1 == "value" && name[n] != "help" { words[n] = words[n] (words[n] ? " " : "") $2 }
$1 == "value" && name[n] == "kernel" { kernels = words[n] }
$1 == "value" && named[n] { ending[n] = ending[n] $2 "= " }
$1 == "model" { models[++nmodels] = $2; patterns[nmodels] = $2 ":*" }
$1 == "key" {
    many = split($3, word, " ")
    for (i = many ? 1 : 0; i <= many; i++)
        keys[nmodels] = keys[nmodels] (keys[nmodels] ? " " : "") $2 "=" word[i]
}
$1 == "preset" {
    for (i = 1; i <= nmodels; i++)
        if (index($3 ":", models[i] ":") == 1)
            patterns[i] = patterns[i] " builtin:" $2 ":*"
}

# Returns text with `by` before each of the characters `set`.
function escaped(text, set, by,    i, c, out) {
    for (i = 1; i <= length(text); i++) {
        c = substr(text, i, 1)
        out = out (index(set, c) ? by : "") c
    }
    return out
}
function spaced(text, between) {
    gsub(/ /, between, text)
    return text
}
function takes(i, command) { return index(in_[i], " " command " ") }

END {
    words[n] = topics # of --help, the last
    print (shell == "zsh" ? "#compdef glarepp\n" : "") "# " shell " completion of glarepp"
    if (shell == "bash") bash(); else if (shell == "zsh") zsh(); else fish()
}

# Readline splits words at = and :, so they are joined first, and the text before the
# last such sign is removed from the completions.
function bash(    i, k) {
    print "_glarepp()\n{\n" \
        "    local n=$COMP_CWORD word=${COMP_WORDS[COMP_CWORD]} option= kind=\n" \
        "    local command=main value words= lead= i\n" \
        "    while ((n > 1)) && [[ $word == [=:]* || ${COMP_WORDS[n - 1]} == [=:] ]]; do\n" \
        "        n=$((n - 1)) word=${COMP_WORDS[n]}$word\n    done\n    value=$word\n" \
        "    case ${COMP_WORDS[1]} in\n    " spaced(space, " | ") ") ((n < 2)) || command=${COMP_WORDS[1]} ;;\n" \
        "    esac\n    if [[ $word == --*=* ]]; then\n" \
        "        option=${word%%=*} value=${word#*=}\n" \
        "    elif ((n > 1)); then\n        option=${COMP_WORDS[n - 1]}\n    fi\n" \
        "    case $option in"
    for (i = 1; i <= n; i++) {
        if (!arg[i])
            continue
        print "    --" name[i] (letter[i] ? " | -" letter[i] : "") ")\n        words='" \
            (model[i] ? kernels : named[i] ? ending[i] : words[i]) "' kind=" (file[i] ? "file" : "value")
        if (named[i])
            print "        [[ $value == *=* ]] && value=${value#*=} words= || kind=value"
        if (model[i]) {
            print "        case $value in"
            for (k = 1; k <= nmodels; k++)
                print "        " spaced(patterns[k], " | ") ") kind=keys words='" keys[k] "' ;;"
            print "        esac\n        if [[ $kind == keys ]]; then\n" \
                "            lead=${value%\"${value##*[:,]}\"}\n            value=${value##*[:,]}\n" \
                "            lead=${lead##*[=:]}\n            [[ $value != *=* ]] || lead=\n        fi"
        }
        print "        ;;"
    }
    print "    esac\n    case $kind:$command:$word in"
    for (k = 0; k < ncommands; k++) {
        printf "    :%s:-*) kind=word words='", commands[k]
        for (i = 1; i <= n; i++)
            if (takes(i, commands[k]))
                printf "--%s ", name[i]
        print "' ;;"
    }
    print "    :help:*) kind=word words='" topics "' ;;\n    :*)\n        kind=file\n" \
        "        ((n > 1)) || words='" space "' ;;\n    esac\n    COMPREPLY=()\n" \
        "    while IFS= read -r i; do\n        COMPREPLY+=(\"$i\")\n" \
        "    done < <([[ -z $words ]] || compgen -W \"$words\" -- \"$value\"\n" \
        "             [[ $kind != file ]] || compgen -f -- \"$value\")\n" \
        "    [[ $kind != file ]] || compopt -o filenames 2>/dev/null\n" \
        "    [[ ${COMPREPLY[*]} != *= ]] || compopt -o nospace 2>/dev/null\n" \
        "    value=${value%\"${value##*[=:]}\"}\n    for i in \"${!COMPREPLY[@]}\"; do\n" \
        "        COMPREPLY[i]=$lead${COMPREPLY[i]#\"$value\"}\n    done\n}\n" \
        "complete -F _glarepp glarepp"
}

# An option's value for _arguments.
function zsh_value(i,    list) {
    list = escaped(words[i], ":", "\\")
    return named[i] ? ":{if compset -P \"*=\"; then _files; else compadd -S = -- " list "; fi}" \
        : model[i] ? ":_glarepp_kernel" : !words[i] ? (file[i] ? ":_files" : ": ") \
        : mark[i] == "open" && arg[i] !~ /^\[/ ? ":{compadd -- " list "; _files}" : ":(" list ")"
}
function zsh(    i, k, l, repeats, value) {
    print "_glarepp_kernel()\n{\n    local -a keys\n    case $PREFIX in"
    for (k = 1; k <= nmodels; k++)
        print "    (" spaced(patterns[k], "|") ") keys=(" keys[k] ") ;;"
    print "    (*) compadd -- " kernels "\n        _files\n        return ;;\n    esac\n" \
        "    compset -P '*[:,]'\n    compadd -S '' -- $keys\n}\n" \
        "_glarepp()\n{\n    local command=main\n    local -a options\n    case $words[2] in\n    " \
        spaced(space, " | ") ")\n        if (( CURRENT > 2 )); then\n            command=$words[2]\n" \
        "            shift words\n            (( CURRENT-- ))\n        fi ;;\n    esac\n" \
        "    (( CURRENT > 2 )) || [[ $command != main ]] ||\n        compadd -- " space \
        "\n    case $command in"
    for (k = 0; k < ncommands; k++) {
        print "    " commands[k] ") options=("
        for (i = 1; i <= n; i++) {
            repeats = mark[i] == "many"
            for (l = 0; takes(i, commands[k]) && l < (letter[i] ? 2 : 1); l++) {
                value = escaped(escaped(text[i], "[]:\\", "\\"), "'", "'\\'")
                print "        '" (repeats ? "*" : letter[i] ? "(-" letter[i] " --" name[i] ")" : "") \
                    (l ? "-" letter[i] (arg[i] ? "+" : "") : "--" name[i] (arg[i] ? "=" : "")) \
                    "[" value "]" (!arg[i] ? "" : \
                    (arg[i] ~ /^\[/ ? "::" : ":") escaped(arg[i], ":", "\\") zsh_value(i)) "'"
            }
        }
        print (commands[k] == "help" ? "        ':topic:(" topics ")'" \
                                     : "        '*:input:_files'") "\n    ) ;;"
    }
    print "    esac\n    _arguments -s -S $options\n}\n_glarepp \"$@\""
}

function fish(    i, k) {
    print "function __glarepp_in\n    set -l words (commandline -opc)\n    set -l command main\n" \
        "    if set -q words[2]; and contains -- $words[2] " space "\n" \
        "        set command $words[2]\n    end\n    contains -- $command $argv\nend\n" \
        "function __glarepp_first\n    test (count (commandline -opc)) -eq 1\nend\n" \
        "complete -c glarepp -n __glarepp_first -a '" space "'\nfunction __glarepp_kernel\n" \
        "    set -l word (commandline -ct | string replace -r '^(--[a-z]+=|-k)' '')\n" \
        "    set -l lead (string replace -r '[^:,]*$' '' -- $word)\n    switch $word"
    for (k = 1; k <= nmodels; k++)
        print "        case '" spaced(patterns[k], "' '") "'\n            printf '%s\\n' $lead{" \
            spaced(keys[k], ",") "}"
    print "        case '*' # or a file\n            printf '%s\\n' " kernels "\n" \
        "            __fish_complete_path $word\n    end\nend\n" \
        "complete -c glarepp -n '__glarepp_in help' -f -a '" topics "'"
    for (i = 1; i <= n; i++)
        print "complete -c glarepp -n '__glarepp_in" substr(in_[i], 1, length(in_[i]) - 1) "' -l " \
            name[i] (letter[i] ? " -s " letter[i] : "") (!arg[i] ? "" : model[i] ? " -r -f" : \
            file[i] ? " -r -F" : " -x") (model[i] ? " -a '(__glarepp_kernel)'" : \
            words[i] ? " -a '" (named[i] ? ending[i] : words[i]) "'" : "") " -d '" escaped(text[i], "'\\", "\\") "'"
}
