#include "host/cli/command.hpp"

int main(int argc, char** argv) {
    return brdfit::cli::run(argc, argv);
}
