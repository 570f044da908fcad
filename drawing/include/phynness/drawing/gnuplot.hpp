// Scripts for gnuplot, the one program that plots are drawn by.
#pragma once

#include <string>

namespace phynness::report {

/// True if a program of that name can be started.
bool gnuplot_is_there();

/// What gnuplot writes to its standard output on `script`; nothing where the script sets another output.
/// @param what  the plot's name or file, for the message; @param remedy  beside installing gnuplot
/// @throws Error (failure) if gnuplot is not there or refuses the script
std::string gnuplot(const std::string& script, const std::string& what, const std::string& remedy);

/// As gnuplot reads it: between single quotes nothing is special, but for the quote itself.
std::string quoted(const std::string& text);

}  // namespace phynness::report
