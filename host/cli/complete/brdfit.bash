# bash completion for brdfit: what its own --help and `brdfit models` say, files otherwise.

_brdfit_help() { # what `brdfit COMMAND... --help` prints
    "${COMP_WORDS[0]}" "$@" --help 2>/dev/null
}

_brdfit_subcommands() {
    _brdfit_help "$@" | sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\) .*/\1/p'
}

_brdfit_options() {
    _brdfit_help "$@" | sed -n 's/^  \(-[^ ]*\).*/\1/p' | tr ',' '\n'
}

_brdfit_models() {
    "${COMP_WORDS[0]}" models 2>/dev/null | sed -n 's/^\([a-z][a-z-]*\)  *\(lobe\|diffuse\),.*/\1/p'
}

_brdfit() {
    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
    local -a command=()
    local word
    for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do # commands come before what they are about
        case "$word" in
        -*) continue ;;
        esac
        if _brdfit_subcommands "${command[@]}" | grep -qxF -- "$word"; then
            command+=("$word")
        fi
    done
    COMPREPLY=()
    case "$previous" in
    -m | --model)
        # A list: the last name is completed.
        local before=""
        case "$current" in
        *[,+]*) before=${current%"${current##*[,+]}"} ;;
        esac
        COMPREPLY=($(compgen -P "$before" -W "all $(_brdfit_models)" -- "${current#"$before"}"))
        return
        ;;
    --metric)
        COMPREPLY=($(compgen -W "ngan l2 log cbrt" -- "$current"))
        return
        ;;
    esac
    case "$current" in
    -*) COMPREPLY=($(compgen -W "$(_brdfit_options "${command[@]}")" -- "$current")) ;;
    *)
        if [ ${#command[@]} -eq 0 ] || [ "${command[*]}" = bench ] || [ "${command[*]}" = help ]; then
            COMPREPLY=($(compgen -W "$(_brdfit_subcommands "${command[@]/help/}")" -- "$current"))
        else
            compopt -o filenames 2>/dev/null
            COMPREPLY=($(compgen -f -- "$current"))
        fi
        ;;
    esac
}
complete -o bashdefault -F _brdfit brdfit
