// Program of the study of the paper. Usage: tools/study-paper [--quick] [-o DIR] [--cases 1,3] [--ranks N]
#include <phynness/formats/error.hpp>
#include <sstream>

#include "command_files.hpp"
#include "streams.hpp"
#include "study.hpp"

namespace phynness::cli {
namespace {

/// @return the exit status, as of the command phynness
int run(int argc, char** argv) {
  CLI::App app{"Runs the paper's Cases 1 to 4 and compares Tables 1 and 2 and Figures 6 to 15 with the paper"};
  app.name("phynness_paper_study");
  add_paper_study(app);
  // Called after the whole command line was parsed and before the study starts.
  app.parse_complete_callback([&app] { check_files(); });
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    std::ostringstream results, messages;
    const int status = app.exit(error, results, messages);
    print_result("{}", results.str());
    message("{}", messages.str());
    return status == 0 ? 0 : 2;
  } catch (const Error& error) {
    // Ranks other than the first fail without a message, so that the reason is printed once.
    if (*error.what() != 0) message("error: {}\n", error.what());
    return error.kind() == Error::Kind::input ? 2 : 1;
  } catch (const std::exception& error) {
    message("error: {}\n", error.what());
    return 1;
  }
}

}  // namespace
}  // namespace phynness::cli

int main(int argc, char** argv) {
  phynness::cli::prepare_streams();
  return phynness::cli::finish_streams(phynness::cli::run(argc, argv));
}
