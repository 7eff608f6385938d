#!/bin/sh
# Kills a run at random moments, 1,000 times or as often as the argument says, and looks whether anything was lost
# or made twice: sh tests/kill_runs.sh [KILLS]. After sh setup.sh test; takes some ten minutes.
set -eu
cd "$(dirname "$0")/.."
BRDFIT_KILLS=${1:-1000} exec build/tests/test_run_faults --gtest_filter='Runs.kills_at_random_moments*'
