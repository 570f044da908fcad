// Claims: eval --queries gives for each row exactly the result of eval for this node and displacement, in the order of
// the rows, for families with and without energy, inside and outside of the trained range, and for a factor of all
// moduli, with which force, energy and bound grow and deformation does not. A file with a wrong row is refused with
// status 2, the line, the value and a remedy, and stdout remains empty. Ten thousand rows take one call. A table that
// is not complete does not look complete.
#include <algorithm>

#include "../pipeline/command_line.hpp"

namespace phynness::test {
namespace {

using Rows = std::vector<std::vector<std::string>>;

class Queries : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml", small_scene());
    make_once({"precompute scene.toml -o d.h5", "train scene.toml d.h5 --family rbfn -o rbfn",
               "train scene.toml d.h5 --family modal -o modal"});
    nodes = active_of("d.h5");
    ASSERT_EQ(nodes.size(), 2u);
  }

  static Rows rows_of(const std::string& csv) {
    Rows rows;
    std::istringstream lines(csv);
    for (std::string line; std::getline(lines, line);) {
      auto& row = rows.emplace_back();
      std::istringstream fields(line);
      for (std::string field; std::getline(fields, field, ',');) row.push_back(field);
    }
    return rows;
  }

  void expect_refused(const std::string& text, const std::vector<std::string>& parts) const {
    write_file(folder / "bad.csv", text);
    const auto outcome = be_refused("eval modal --queries bad.csv");
    EXPECT_EQ(outcome.out, "") << text;
    expect_error(outcome.err, parts);
  }

  std::vector<int> nodes;
};

// The trained range is 8 mm: the last displacement lies beyond it and is answered with a warning in its status.
TEST_F(Queries, AreAnsweredAsOneByOne) {
  const char* displacements[] = {"0,0,0", "0,0,-0.006", "0.0012345678901234567,-1e-4,+0.003", "0.011,0.005,-0.02"};
  for (const std::string family : {"rbfn", "modal"}) {
    const bool has_energy = family == "modal";
    std::string csv = "node,ux_m,uy_m,uz_m\n";
    for (const int node : nodes)
      for (const char* d : displacements) csv += std::to_string(node) + "," + d + "\n";
    write_file(folder / "queries.csv", csv);
    const auto all = succeed("eval " + family + " --queries queries.csv");
    EXPECT_EQ(all.err, "");
    const auto rows = rows_of(all.out);
    ASSERT_EQ(rows.size(), 1 + nodes.size() * std::size(displacements));
    EXPECT_EQ(all.out.substr(0, all.out.find('\n')), std::string("node,ux_m,uy_m,uz_m,fx_N,fy_N,fz_N") +
                                                         (has_energy ? ",energy_J" : "") + ",status,trained_depth_m");
    bool warned = false;
    for (std::size_t r = 1; r < rows.size(); ++r) {
      const auto& row = rows[r];
      const std::string node = std::to_string(nodes[(r - 1) / std::size(displacements)]),
                        d = displacements[(r - 1) % std::size(displacements)];
      ASSERT_EQ(row.size(), has_energy ? 10u : 9u);
      EXPECT_EQ(row[0], node);
      const auto one = succeed("eval " + family + " --node " + node + " --displacement " + d + " --json one.json");
      const auto answer = json("one.json");
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(std::stod(row[1 + k]), answer.at("tools").at(0).at("displacement").at(k).get<double>()) << node << d;
        EXPECT_EQ(std::stod(row[4 + k]), answer.at("tools").at(0).at("force").at(k).get<double>()) << node << d;
      }
      if (has_energy) {
        EXPECT_EQ(std::stod(row[7]), answer.at("energy").get<double>()) << node << d;
      }
      EXPECT_EQ(std::stoi(row[row.size() - 2]), answer.at("status").get<int>()) << node << d;
      warned = warned || std::stoi(row[row.size() - 2]) > 0;
      const double depth = std::stod(row.back());
      // Every ray of this block was solved to its end.
      EXPECT_NEAR(depth, 0.008, 1e-12) << node << d;
    }
    EXPECT_TRUE(warned);
  }
}

TEST_F(Queries, BeyondTheTrainedDepthAreWarnedOfWithBothLengths) {
  const auto node = std::to_string(nodes[0]);
  const auto outcome = succeed("eval modal --node " + node + " --displacement 0,0,-0.0125");
  expect_names(outcome.err, {"warning: ", "node " + node, "0.0125 m", "0.008 m"});
  const auto inside = phynness("eval modal --node " + node + " --displacement 0,0,-0.006");
  EXPECT_EQ(inside.err, "");
}

TEST_F(Queries, WithABadRowAreRefusedByItsLine) {
  const std::string head = "node,ux_m,uy_m,uz_m\n", good = std::to_string(nodes[0]) + ",0,0,-0.001\n";
  const auto node = std::to_string(nodes[1]);
  for (const char* d : {"nan,0,0", "0,inf,0", "0,0,-1e999", "0,0,x", "0,0,", "0,0,0.1m", "0,0,0x1", "1e999,0,0"})
    expect_refused(head + good + node + "," + d + "\n", {"bad.csv, line 3", "displacement", "0.0,0.0,-0.01"});
  for (const char* row : {"1", "1,0,0", "1,0,0,0,0", "1;0;0;0", ""})
    expect_refused(head + good + row + "\n" + good, {"bad.csv, line 3", "4 values", std::string("'") + row + "'"});
  for (const char* number : {"", "1.0", "x", "99999999999"})
    expect_refused(head + number + ",0,0,0\n", {"bad.csv, line 2", "node", std::string("'") + number + "'"});
  for (const char* number : {"-1", "100000"})
    expect_refused(head + good + good + number + ",0,0,0\n", {"bad.csv, line 4", std::string("node ") + number});
  expect_refused(head + node + ",0,0,-2e6\n", {"bad.csv, line 2", "-2e6", "metres"});
  expect_refused(head + good + node + ",1e308,1e308,0\n", {"bad.csv, line 3", "1e308", "metres"});
  // Without its first line a file is refused, and not taken for one with a row less.
  expect_refused(good, {"bad.csv, line 1", "node,ux_m,uy_m,uz_m"});
  expect_refused("", {"bad.csv, line 1", "node,ux_m,uy_m,uz_m"});
  expect_refused(head, {"bad.csv", "no rows"});
}

TEST_F(Queries, WithAnInactiveNodeNameTheNearest) {
  // The block is fixed below and touched above: it has other nodes.
  int inactive = 0;
  while (std::find(nodes.begin(), nodes.end(), inactive) != nodes.end()) ++inactive;
  const auto row = std::to_string(nodes[0]) + ",0,0,0\n";
  expect_refused("node,ux_m,uy_m,uz_m\n" + row + std::to_string(inactive) + ",0,0,0\n",
                 {"bad.csv, line 3", "node " + std::to_string(inactive), "nearest"});
}

TEST_F(Queries, AreNotMixedWithASingleOne) {
  write_file(folder / "queries.csv", "node,ux_m,uy_m,uz_m\n" + std::to_string(nodes[0]) + ",0,0,0\n");
  for (const std::string more :
       {"--node 1 --displacement 0,0,0", "--json a.json", "--deformation a.csv", "--surface a.vtu", "--point 0,0,0"})
    expect_names(be_refused("eval modal --queries queries.csv " + more).err, {"--queries"});
  be_refused("eval modal --queries missing.csv");
  be_refused("eval modal --queries modal");
}

// As spreadsheets on other systems write files: a mark in front, \r\n, no end of the last line, spaces. 10,000 rows.
TEST_F(Queries, AreAnsweredByTheThousand) {
  std::string plain = "node,ux_m,uy_m,uz_m\n", other = "\xEF\xBB\xBFnode,ux_m,uy_m,uz_m\r\n";
  constexpr int n = 10000;
  for (int i = 0; i < n; ++i) {
    const auto node = std::to_string(nodes[i % 2]), z = std::to_string(-1e-6 * (i % 8000));
    plain += node + ",0.001,0," + z + "\n";
    other += " " + node + " , 0.001,0 ," + z + (i + 1 < n ? "\r\n" : "");
  }
  write_file(folder / "plain.csv", plain);
  write_file(folder / "other.csv", other);
  const auto a = succeed("eval modal --queries plain.csv"), b = phynness("eval modal --queries other.csv");
  ASSERT_EQ(b.exit_status, 0) << b.err;
  EXPECT_EQ(std::count(a.out.begin(), a.out.end(), '\n'), n + 1);
  EXPECT_EQ(a.out, b.out);
}

TEST_F(Queries, AreWrittenToAFileOnlyAsAWhole) {
  const std::string head = "node,ux_m,uy_m,uz_m\n", good = std::to_string(nodes[0]) + ",0,0,-0.001\n";
  write_file(folder / "good.csv", head + good + good);
  write_file(folder / "bad.csv", head + good + "x\n");
  const auto printed = phynness("eval modal --queries good.csv"),
             written = phynness("eval modal --queries good.csv -o t.csv");
  ASSERT_EQ(written.exit_status, 0) << written.err;
  EXPECT_EQ(written.out, "");
  EXPECT_EQ(read_file(folder / "t.csv"), printed.out);
  be_refused("eval modal --queries bad.csv -o t.csv");
  EXPECT_EQ(read_file(folder / "t.csv"), printed.out);
  EXPECT_FALSE(std::filesystem::exists(folder / "t.csv.part"));
  be_refused("eval modal --queries good.csv -o good.csv");
  be_refused("eval modal --node 1 --displacement 0,0,0 -o t.csv");
  EXPECT_EQ(read_file(folder / "good.csv"), head + good + good);
}

// 10,000 rows take 0.8 MB. The limit of the shell is in blocks of 512 or 1024 bytes.
TEST_F(Queries, OfAFullDiskKeepTheirRowsUnderAnotherName) {
  std::string csv = "node,ux_m,uy_m,uz_m\n";
  for (int i = 0; i < 10'000; ++i) csv += std::to_string(nodes[0]) + ",0.001,0,0\n";
  write_file(folder / "queries.csv", csv);
  const auto outcome = shell("ulimit -f 200; \"$PHYNNESS\" eval modal --queries queries.csv -o t.csv");
  EXPECT_EQ(outcome.exit_status, 1);
  expect_error(outcome.err, {"writing failed: t.csv; what is written is in t.csv.part", "free space"});
  EXPECT_FALSE(std::filesystem::exists(folder / "t.csv"));
  const auto kept = read_file(folder / "t.csv.part"), whole = phynness("eval modal --queries queries.csv").out;
  EXPECT_GT(kept.size(), 50'000u);
  EXPECT_EQ(whole.substr(0, kept.size()), kept);
  const auto device = phynness("eval modal --queries queries.csv -o /dev/full");
  EXPECT_EQ(device.exit_status, 1);
  expect_error(device.err, {"writing failed: /dev/full"});
}

// A full disk is an error; that the reader of a pipe has read enough is none.
TEST_F(Queries, EndWhereNobodyTakesTheirRows) {
  std::string csv = "node,ux_m,uy_m,uz_m\n";
  for (int i = 0; i < 50'000; ++i) csv += std::to_string(nodes[0]) + ",0.001,0,0\n";
  write_file(folder / "queries.csv", csv);
  const auto full = phynness("eval modal --queries queries.csv > /dev/full");
  EXPECT_EQ(full.exit_status, 1);
  expect_error(full.err, {"results could not be written to stdout"});
  const auto pipe = shell(
      "{ \"$PHYNNESS\" eval modal --queries queries.csv; echo $? > status; } | head -n 2; "
      "while ! [ -s status ]; do sleep 0.05; done");
  EXPECT_EQ(read_file(folder / "status"), "0\n");
  EXPECT_EQ(pipe.err.find("error"), std::string::npos) << pipe.err;
}

// The table is longer than a pipe holds, so that the command cannot have ended when the signal comes.
TEST_F(Queries, InterruptedSaySoBehindTheLastRow) {
  std::string csv = "node,ux_m,uy_m,uz_m\n";
  for (int i = 0; i < 50'000; ++i) csv += std::to_string(nodes[0]) + ",0.001,0,0\n";
  write_file(folder / "queries.csv", csv);
  const auto outcome = shell(
      "mkfifo p; \"$PHYNNESS\" eval modal --queries queries.csv > p & pid=$!; exec 3< p; head -c 100 <&3 > /dev/null; "
      "kill -TERM $pid; cat <&3; wait $pid");
  EXPECT_EQ(outcome.exit_status, 1) << outcome.err;
  expect_error(outcome.err, {"eval was interrupted", "of 50000 rows", "on stdout"});
  const auto last = outcome.out.substr(outcome.out.rfind('\n', outcome.out.size() - 2) + 1);
  EXPECT_EQ(last.rfind("interrupted: ", 0), 0u) << last;
}

}  // namespace
}  // namespace phynness::test
