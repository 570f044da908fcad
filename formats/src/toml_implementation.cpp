// toml++ compiled once, so that the files which only read its tables stay quick to build.
#define TOML_IMPLEMENTATION
#include <toml++/toml.h>
