// wax-port-test: the promises of `port.h`, put to the test on a board that is made up.
#include <stdio.h>
#include <string.h>

#include "../port_test/promises.h"
#include "fake_board.h"

int main(int count, char **words) {
    if (count == 2 && strcmp(words[1], "--faults") == 0) {
        for (unsigned at = 0; at < fake::FAULT_COUNT; ++at) puts(fake::FAULTS[at]);
        return 0;
    }
    const bool is_blind = count == 2 && strcmp(words[1], "--blind") == 0;
    const bool is_broken = count == 3 && strcmp(words[1], "--fault") == 0;
    if ((count > 1 && !is_blind && !is_broken) || (is_broken && !fake::break_it(words[2]))) {
        fputs("usage: wax-port-test [--faults | --blind | --fault NAME]\n", stderr);
        return 2;
    }
    if (is_blind) fake::blind_it();
    return port_test::run() ? 1 : 0;
}
