"""The public targets that CI forgets, one a line; exit 1 when there is one.
usage: make -npq | targets.py CI-SCRIPT TARGET...

Each TARGET needs files in build/. Those must be needed too by a target that CI-SCRIPT makes; what make does not know, as another make
builds it, must be made by CI-SCRIPT: by TARGET itself, or by a target that both need."""
import re
import sys

STAMP = re.compile(r'/\.[a-z0-9-]+-packages$')  # says that packages are there
OTHER_MAKE = re.compile(r'\$\(MAKE\)(?! -[A-Za-z]*n)')  # one that runs, not one that only says what it would


def read_rules(lines):
    """needs: what each target needs; others: those whose recipe runs another make."""
    needs, others, target, unknown = {}, set(), None, False
    for line in lines:
        rule = re.match(r'([^\s#:=][^:=]*?)(?: &)?::?(?!=)\s*(.*)', line)
        if line.startswith('\t'):
            if target and OTHER_MAKE.search(line):
                others.add(target)
        elif line.startswith('# Not a target'):
            unknown = True
        elif rule and not unknown:
            target = rule[1]
            needs.setdefault(target, set()).update(word for word in rule[2].split() if word != '|')
        elif not line.strip():
            target, unknown = None, False
    return needs, others


def all_needs(needs, targets):
    found, waiting = set(), list(targets)
    while waiting:
        target = waiting.pop()
        if target not in found:
            found.add(target)
            waiting += needs.get(target, ())
    return found


def main():
    needs, others = read_rules(sys.stdin)
    made = set()
    for line in open(sys.argv[1]):
        words = line.split('#')[0].split()
        if 'make' in words:
            made.update(word for word in words[words.index('make') + 1:] if not word.startswith('-'))
    covered = all_needs(needs, made)
    status = 0
    for name in sys.argv[2:]:
        of = all_needs(needs, [name])
        missing = sorted(file for file in of - covered if file.startswith('build/') and not STAMP.search(file))
        missing += sorted(target for target in of & others if target not in covered)
        if name not in needs or missing:
            print('%s: nothing in %s builds %s' % (name, sys.argv[1], ', '.join(missing) or 'such a target'))
            status = 1
    return status


sys.exit(main())
