// Claim: solve --queries gives for each row exactly the result of solve for this node and displacement, whatever rows
// stand before it, in the order of the rows. A row without a solution has its reason and costs no other row; a row that
// is no query is refused with its line before anything is solved. What is finished at a signal is kept in a file of
// another name.
#include "command_line.hpp"

namespace phynness::test {
namespace {

const char* const head = "node,ux_m,uy_m,uz_m\n";

class SolvedQueries : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml", small_scene());
  }

  /// The lines below the first one, cut at their commas into at most `most` fields.
  static std::vector<std::vector<std::string>> rows_of(const std::string& csv, std::size_t most) {
    std::vector<std::vector<std::string>> rows;
    std::istringstream lines(csv);
    std::string line;
    std::getline(lines, line);
    while (std::getline(lines, line)) {
      auto& row = rows.emplace_back();
      while (row.size() + 1 < most && line.find(',') != std::string::npos) {
        row.push_back(line.substr(0, line.find(',')));
        line.erase(0, line.find(',') + 1);
      }
      row.push_back(line);
    }
    return rows;
  }

  void expect_refused(const std::string& text, const std::vector<std::string>& parts) const {
    write_file(folder / "bad.csv", text);
    const auto outcome = be_refused("solve scene.toml --queries bad.csv -o none.csv");
    EXPECT_EQ(outcome.out, "") << text;
    EXPECT_FALSE(std::filesystem::exists(folder / "none.csv"));
    expect_names(outcome.err, parts);
  }

  /// Nodes of the top that can move, found as a user would.
  std::vector<std::string> free_nodes() const {
    std::vector<std::string> nodes;
    for (int n = 0; nodes.size() < 2 && n < 50; ++n)
      if (phynness("solve scene.toml --node " + std::to_string(n) + " --displacement 0,0,0").exit_status == 0)
        nodes.push_back(std::to_string(n));
    return nodes;
  }
};

TEST_F(SolvedQueries, AreSingleSolves) {
  const auto nodes = free_nodes();
  ASSERT_EQ(nodes.size(), 2u);
  const std::string &a = nodes[0], &b = nodes[1];
  const std::vector<std::pair<std::string, std::string>> queries{{b, "0.001,0.0012345678901234567,-0.004"},
                                                                 {a, "1000000,0,0"},
                                                                 {a, "0,0.003,-0.002"},
                                                                 {b, "0,0,0"},
                                                                 {a, "-0.002,0,0.001"},
                                                                 {b, "0,0,-0.006"}};
  std::string csv = head;
  for (const auto& [node, d] : queries) csv += node + "," + d + "\r\n";
  csv.resize(csv.size() - 2);  // the last line has no end
  write_file(folder / "queries.csv", csv);
  const auto all = succeed("solve scene.toml --queries queries.csv");
  expect_names(all.err, {"without a solution: 1"});
  EXPECT_EQ(all.out.substr(0, all.out.find('\n')), "node,ux_m,uy_m,uz_m,fx_N,fy_N,fz_N,energy_J,status,note");
  const auto rows = rows_of(all.out, 10);
  ASSERT_EQ(rows.size(), queries.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto& [node, d] = queries[i];
    SCOPED_TRACE(node + " " + d);
    const auto& row = rows[i];
    ASSERT_EQ(row.size(), 10u);
    EXPECT_EQ(row[0], node);
    const auto one = phynness("solve scene.toml --node " + node + " --displacement " + d + " --json one.json");
    if (i == 1) {
      EXPECT_EQ(one.exit_status, 1);
      EXPECT_LT(std::stoi(row[8]), 0);
      EXPECT_EQ(row[4] + row[5] + row[6] + row[7], "");
      EXPECT_NE(one.err.find(row[9].substr(1, row[9].size() - 2)), std::string::npos) << row[9] << one.err;
      continue;
    }
    ASSERT_EQ(one.exit_status, 0) << one.err;
    const auto answer = json("one.json");
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(std::stod(row[1 + k]), answer["tools"][0]["displacement"][k].get<double>());
      EXPECT_EQ(std::stod(row[4 + k]), answer["tools"][0]["force"][k].get<double>());
    }
    EXPECT_EQ(std::stod(row[7]), answer["energy"].get<double>());
    EXPECT_EQ(row[8], "0");
  }
}

TEST_F(SolvedQueries, WithABadRowAreRefusedBeforeAnySolve) {
  const auto nodes = free_nodes();
  ASSERT_EQ(nodes.size(), 2u);
  const std::string good = nodes[0] + ",0,0,-0.001\n";
  expect_refused(head + good + "1,0,0\n" + good, {"bad.csv, line 3"});
  expect_refused(head + good + "100000,0,0,0\n", {"bad.csv, line 3", "node 100000", "no such node"});
  expect_refused(head + nodes[0] + ",1e-300,0,0\n", {"bad.csv, line 2", "too small"});
  write_file(folder / "queries.csv", head + good);
  for (const char* more : {"--node 1 --displacement 0,0,0", "--json a.json", "--deformation a.csv", "--tangent"})
    expect_names(be_refused(std::string("solve scene.toml --queries queries.csv ") + more).err, {"--queries"});
  const auto ranks = shell("mpirun -n 2 --oversubscribe \"$PHYNNESS\" solve scene.toml --queries queries.csv");
  EXPECT_EQ(ranks.exit_status, 2) << ranks.err;
  EXPECT_NE(ranks.err.find("without mpirun"), std::string::npos) << ranks.err;
  EXPECT_EQ(ranks.out, "");
}

// A hundred thousand solves take minutes: the signal comes when a row is on the disk below the header.
TEST_F(SolvedQueries, InterruptedKeepTheirRowsUnderAnotherName) {
  const auto nodes = free_nodes();
  ASSERT_EQ(nodes.size(), 2u);
  std::string csv = head;
  for (int i = 0; i < 100'000; ++i) csv += nodes[0] + ",0.0001,0," + std::to_string(-1e-8 * i) + "\n";
  write_file(folder / "queries.csv", csv);
  const auto outcome = signalled("\"$PHYNNESS\" solve scene.toml --queries queries.csv -o t.csv",
                                 "[ \"$(cat t.csv.part 2>/dev/null | wc -l)\" -gt 1 ]", "kill $pid");
  EXPECT_EQ(outcome.exit_status, 1) << outcome.err;
  expect_names(outcome.err, {"solve was interrupted", "of 100000 rows", "t.csv.part"});
  EXPECT_FALSE(std::filesystem::exists(folder / "t.csv"));
  const auto kept = read_file(folder / "t.csv.part");
  EXPECT_EQ(kept.back(), '\n');
  const auto rows = rows_of(kept, 10);
  EXPECT_GT(rows.size(), 0u);
  EXPECT_LT(rows.size(), 100'000u);
  expect_names(outcome.err, {std::to_string(rows.size()) + " of 100000"});
  for (const auto& row : rows) ASSERT_EQ(row.size(), 10u);
}

}  // namespace
}  // namespace phynness::test
