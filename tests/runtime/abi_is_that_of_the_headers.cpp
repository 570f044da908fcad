// Claims about what a binding is told: phn_sizeof knows every struct of the headers, with its size; there are at most
// 60 functions in at most 7 headers besides phynness_api.h; reserved words that are not 0 are refused.
#include <gtest/gtest.h>
#include <phynness/phynness_contact.h>
#include <phynness/phynness_image.h>
#include <phynness/phynness_loop.h>
#include <phynness/phynness_surface.h>
#include <phynness/phynness_tools.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>

namespace {

/// Texts of the C headers by their names.
std::map<std::string, std::string> headers() {
  std::map<std::string, std::string> texts;
  for (const auto& entry : std::filesystem::directory_iterator(PHYNNESS_HEADERS)) {
    if (entry.path().extension() != ".h") continue;
    std::ostringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    texts[entry.path().filename().string()] = text.str();
  }
  return texts;
}

#define SIZE(type) \
  { #type, sizeof(type) }

TEST(Abi, KnowsEveryStructOfTheHeaders) {
  EXPECT_EQ(phn_abi_version(), PHN_ABI_VERSION);
  EXPECT_EQ(phn_sizeof("phn_model"), 0);
  EXPECT_EQ(phn_sizeof(nullptr), 0);
  const std::map<std::string, std::size_t> sizes = {
      SIZE(phn_provenance),       SIZE(phn_info),          SIZE(phn_relaxation),
      SIZE(phn_relaxing),         SIZE(phn_tool),          SIZE(phn_level),
      SIZE(phn_coupled),          SIZE(phn_body_contents), SIZE(phn_body_report),
      SIZE(phn_contact_tool),     SIZE(phn_contact_state), SIZE(phn_contact_report),
      SIZE(phn_surface_contents), SIZE(phn_loop_settings), SIZE(phn_loop_response),
      SIZE(phn_loop_report),      SIZE(phn_bridge),        SIZE(phn_image_contents),
      SIZE(phn_image_tool)};
  std::size_t n = 0;
  for (const auto& [name, text] : headers()) {
    const std::regex definition("typedef struct (phn_\\w+) \\{");
    for (auto it = std::sregex_iterator(text.begin(), text.end(), definition); it != std::sregex_iterator();
         ++it, ++n) {
      const std::string type = (*it)[1];
      ASSERT_EQ(sizes.count(type), 1u) << type << " of " << name << ": add it here and to src/core/abi.cpp";
      EXPECT_EQ(static_cast<std::size_t>(phn_sizeof(type.c_str())), sizes.at(type)) << type;
    }
  }
  EXPECT_EQ(n, sizes.size());
}

TEST(Abi, HasFewFunctions) {
  std::size_t n_functions = 0, n_headers = 0;
  for (const auto& [name, text] : headers()) {
    const std::regex function("\nPHN_API ");
    n_functions += static_cast<std::size_t>(
        std::distance(std::sregex_iterator(text.begin(), text.end(), function), std::sregex_iterator()));
    n_headers += name != "phynness_api.h";
  }
  EXPECT_LE(n_functions, 60u);
  EXPECT_GT(n_functions, 40u);  // they were found
  EXPECT_LE(n_headers, 7u);
}

TEST(Abi, RefusesReservedWords) {
  phn_loop_settings settings;
  ASSERT_EQ(phn_loop_defaults(&settings), PHN_OK);
  std::size_t bytes = 0;
  ASSERT_EQ(phn_loop_size(&bytes), PHN_OK);
  std::vector<double> memory(bytes / sizeof(double) + 1);
  phn_loop* loop = nullptr;
  ASSERT_EQ(phn_loop_init(memory.data(), bytes, &settings, &loop), PHN_OK);
  phn_loop_response response{};
  response.reserved[1] = 7;
  double force[3] = {1, 1, 1};
  EXPECT_EQ(phn_loop_hold(loop, &response, 1, force), PHN_ERROR_VERSION);
  EXPECT_EQ(force[0], 0);
  settings.reserved[0] = 1;
  EXPECT_EQ(phn_loop_init(memory.data(), bytes, &settings, &loop), PHN_ERROR_VERSION);
  phn_bridge bridge{};
  bridge.reserved = 1;
  EXPECT_EQ(phn_bridge_force(&bridge, force, 1, force), PHN_ERROR_VERSION);
}

}  // namespace
