"""compile_commands.json from what make would run: make -Bn all | compile_commands.py FOLDER"""
import json
import shlex
import sys

commands = []
for line in sys.stdin.read().replace('\\\n', ' ').splitlines():
    if not line.split(' ', 1)[0].endswith(('gcc', 'clang', 'cc')):
        continue
    words = shlex.split(line)
    commands += [{'directory': sys.argv[1], 'file': word, 'arguments': words} for word in words if word.endswith('.c')]
json.dump(commands, sys.stdout, indent=1)
