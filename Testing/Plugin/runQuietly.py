"""Runs a command that must succeed without a word on stderr.

runQuietly.py [--expect <regular expression>] [--ignore <regular expression>] -- <command>...

With --expect it must print one or more VTK errors to stderr instead, and each must match. Errors that match
--ignore do not count.
"""

import re
import subprocess
import sys

separator = sys.argv.index("--")
options = dict(zip(sys.argv[1:separator:2], sys.argv[2:separator:2]))
command = sys.argv[separator + 1:]

done = subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
print(done.stdout)
print(done.stderr, file=sys.stderr)
if done.returncode != 0:
    sys.exit(f"{command[0]} ended with {done.returncode}")
errors = re.split(r"^(?=.*\b(?:ERR|WARN)\|)", done.stderr, flags=re.MULTILINE)
errors = [error for error in errors if error.strip()]
if "--ignore" in options:
    errors = [error for error in errors if not re.search(options["--ignore"], error)]
if "--expect" in options:
    if not errors or not all(re.search(options["--expect"], error) for error in errors):
        sys.exit(f"stderr should have had errors like '{options['--expect']}' and nothing else.")
elif errors:
    sys.exit("Nothing should have been printed to stderr.")
