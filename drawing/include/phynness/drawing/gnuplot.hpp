// Runs scripts in gnuplot, which draws all plots.
#pragma once

#include <string>

namespace phynness::report {

/// True if gnuplot can be started.
bool gnuplot_is_there();

/// Standard output of gnuplot for `script`; empty if the script sets another output.
/// @param what    name or file of the plot, for the message
/// @param remedy  alternative to the installation of gnuplot
/// @throws Error (failure) if gnuplot is not installed or refuses the script
std::string gnuplot(const std::string& script, const std::string& what, const std::string& remedy);

/// Text in single quotes for gnuplot, in which only the quote itself is special.
std::string quoted(const std::string& text);

}  // namespace phynness::report
