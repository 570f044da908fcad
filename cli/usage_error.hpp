// Errors of the command line in the form of all other errors: what, value, remedy.
#pragma once

#include <CLI/CLI.hpp>
#include <phynness/formats/error.hpp>

namespace phynness::cli {

/// @param app    as its parse left it
/// @param error  what the parse threw; not the call for help or version
Error usage_error(const CLI::App& app, const CLI::ParseError& error);

}  // namespace phynness::cli
