// Claims: no command overwrites its inputs, whatever the spelling of the output, or another of its outputs. It exits
// with 2, names options and paths, and changes no file. The commands and their options are taken from --help; an option
// for a path that is not declared as INPUT or OUTPUT fails the test.
#include <algorithm>
#include <map>
#include <set>

#include "../pipeline/command_line.hpp"
#include "offered_options.hpp"

namespace phynness::test {
namespace {

namespace fs = std::filesystem;

/// Texts that are not names of files. A new option that names a file is declared, with add_path() of
/// cli/command_files.hpp.
const std::set<std::string> texts{"--part",      "--displacement", "--point",     "--tools", "--family",
                                  "--max-error", "--max-time",     "--increment", "--name",  "--reference"};

/// A subcommand with the inputs that it is given.
struct Use {
  std::string command, inputs;
  std::vector<std::string> read;  ///< files and folders of the inputs
  std::vector<OfferedOption> outputs;
  bool exclusive = false;  ///< has an input that excludes others of its kind
};

class Overwriting : public CommandLine {
 protected:
  /// A scene in one folder whose mesh lies in another, and a database, an unfinished one and a model made of it.
  void SetUp() override {
    CommandLine::SetUp();
    for (const char* name : {"scenes", "parts", "fresh", "fresh/there"}) fs::create_directory(folder / name);
    write_file(folder / "block.toml", small_scene());
    auto text = small_scene();
    const auto from = text.find("shape = "), to = text.find("[material]");
    text.replace(from, to - from, "file = \"../parts/body.msh\"\n");
    write_file(folder / "scenes/scene.toml", text);
    for (const char* line : {"mesh block.toml -o parts/body.msh", "precompute scenes/scene.toml -o d.h5",
                             "precompute scenes/scene.toml -o s.h5 --part 0/2", "train scenes/scene.toml d.h5 -o model",
                             "info d.h5 --json fresh/info.json"}) {
      succeed(line);
    }
    node = std::to_string(json("fresh/info.json").at("active").at(0).get<int>());
    succeed("info model --json fresh/info.json");
    const auto of_model = json("fresh/info.json");
    fs::remove(folder / "fresh/info.json");
    write_file(folder / "queries.csv", "node,ux_m,uy_m,uz_m\n" + node + ",0,0,-0.001\n");
    write_file(folder / "errors.json", "{\"by_node\": {\"nodes\": [" + node +
                                           "], \"force_error\": [0.1], \"displacement_error\": [0.1]}, " +
                                           "\"model_hash\": " + of_model.at("model_hash").dump() +
                                           ", \"mesh_hash\": " + of_model.at("mesh_hash").dump() + "}\n");
    write_file(folder / "check.json",
               "{\"mesh_hash\": " + of_model.at("mesh_hash").dump() +
                   ", \"physics_hash\": " + of_model.at("physics_hash").dump() +
                   ", \"distance\": {\"element\": \"P1\", \"revision\": 1, \"reference\": " +
                   "\"half-size\", \"probes\": 0, \"tool_radius_m\": 0.01, \"mean\": 0, \"p95\": 0, " +
                   "\"nodes\": 100, \"solved\": 0}}\n");
    write_file(folder / "body.txt", "phynness-body 1\n");
  }

  /// Every file in the folder with its bytes.
  std::map<std::string, std::string> files() const {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      const auto name = entry.path().lexically_relative(folder).string();
      if (entry.is_regular_file() && name != "stdout.txt" && name != "stderr.txt") all[name] = read_file(entry.path());
    }
    return all;
  }

  Offered offered(const std::string& command) const {
    const auto help = succeed(command + " --help");
    return offered_options(help.out);
  }

  /// All subcommands that --help lists, with those below them.
  std::vector<std::string> commands(const std::string& above = "") const {
    std::vector<std::string> all;
    for (const auto& word : offered(above).subcommands) {
      const auto name = above.empty() ? word : above + " " + word;
      const auto below = commands(name);
      if (below.empty()) all.push_back(name);
      all.insert(all.end(), below.begin(), below.end());
    }
    return all;
  }

  /// What INPUT options and other required ones are given; one entry for each kind of input.
  std::vector<std::pair<std::string, std::vector<std::string>>> values(const std::string& option) const {
    const std::vector<std::string> scene{"scenes/scene.toml", "parts/body.msh"}, database{"d.h5"},
        model{"model/model.txt", "model/mesh.txt", "model"};
    if (option == "SCENE") return {{"scenes/scene.toml", scene}};
    if (option == "SCENE or database") return {{"scenes/scene.toml", scene}, {"d.h5", database}};
    if (option == "DATABASE") return {{"d.h5", database}};
    if (option == "--database") return {{"--database d.h5", database}};
    if (option == "FILE") return {{"d.h5", database}};
    if (option == "--scene") return {{"--scene scenes/scene.toml", scene}};
    if (option == "--body") return {{"--body body.txt", {"body.txt"}}};
    if (option == "--errors") return {{"--errors errors.json", {"errors.json"}}};
    if (option == "--check") return {{"--check check.json", {"check.json"}}};
    if (option == "MODEL_DIR") return {{"model", model}};
    if (option == "--model") return {{"--model model", model}};
    if (option == "--queries") return {{"--queries queries.csv", {"queries.csv"}}};
    if (option == "FILE_OR_DIR")
      return {
          {"scenes/scene.toml", scene},           {"d.h5", database},         {"model", model},
          {"parts/body.msh", {"parts/body.msh"}}, {"body.txt", {"body.txt"}}, {"s.h5", {"s.h5", "s.h5.log/rank-0000"}}};
    if (option == "--node") return {{"--node " + node, {}}};
    if (option == "--displacement") return {{"--node " + node + " --displacement 0,0,-0.001", {}}};
    if (option == "--direction") return {{"--direction 0", {}}};
    ADD_FAILURE() << "this test does not know what to give to " << option;
    return {};
  }

  std::vector<Use> uses(const std::string& command) const {
    const auto all = offered(command);
    std::vector<Use> found{{command, "", {}, all.of_type("OUTPUT"), false}};
    for (const auto& option : all.options) {
      if (option.type == "OUTPUT" || !(option.required || option.type == "INPUT")) continue;
      const bool either = option.name == "SCENE" && command == "solve";
      const bool exclusive = !option.required && option.excludes;
      auto longer = exclusive ? found : std::vector<Use>();
      for (const auto& use : found)
        for (const auto& [words, read] : values(either ? "SCENE or database" : option.name)) {
          if (exclusive && use.exclusive) continue;
          longer.push_back(use);
          longer.back().inputs += " " + words + (command == "validate" && option.name == "--body" ? " --points 1" : "");
          longer.back().read.insert(longer.back().read.end(), read.begin(), read.end());
          longer.back().exclusive = use.exclusive || exclusive;
        }
      found = longer;
    }
    const auto excludes = [](const OfferedOption& option) { return option.type == "INPUT" && option.excludes; };
    if (std::ranges::any_of(all.options, excludes))
      for (auto& use : found)
        if (!use.exclusive) use.inputs += " --node " + node + " --displacement 0,0,-0.001";
    return found;
  }

  /// The command line with the option `name` at `place`, the other required outputs at places of their own.
  static std::string line(const Use& use, const std::map<std::string, std::string>& places) {
    auto words = use.command + use.inputs;
    int n = 0;
    for (const auto& option : use.outputs) {
      const auto place = places.find(option.name);
      if (place != places.end())
        words += " " + option.name + " '" + place->second + "'";
      else if (option.required)
        words += " " + option.name + " fresh/other" + std::to_string(n++);
    }
    return words;
  }

  void expect_refused(const std::string& words, const std::string& option) {
    const auto before = files();
    const auto outcome = be_refused(words);
    // A plot is refused earlier if its name does not end in .html, and a folder where a file is; so are other outputs
    // than the table of --queries.
    const bool earlier = outcome.err.find(".html") != std::string::npos ||
                         outcome.err.find(" excludes ") != std::string::npos ||
                         outcome.err.find(" requires ") != std::string::npos ||
                         outcome.err.find("an output cannot be written") != std::string::npos;
    SCOPED_TRACE(words);
    expect_error(outcome.err, {earlier ? "error: " : "would overwrite", option});
    EXPECT_EQ(outcome.out, "") << words;
    ASSERT_TRUE(files() == before) << words << ": files are not as they were";
  }

  /// Other names of what `path` is; links are made where they are needed.
  std::vector<std::string> spellings(const std::string& path) {
    std::vector<std::string> all{path, "./fresh/.././" + path, (folder / path).string(), "fresh/there/../../" + path};
    const auto link = [&](const char* name) { return "fresh/" + std::string(name) + std::to_string(links++); };
    all.push_back(link("symbolic"));
    fs::create_symlink(fs::path("..") / path, folder / all.back());
    const auto around = link("folder");
    fs::create_directory_symlink(folder, folder / around);
    all.push_back(around + "/" + path);
    if (fs::is_directory(folder / path)) all.insert(all.end(), {path + "/", path + "/.", path + "/new"});
    return all;
  }

  std::string node;
  int links = 0;
};

TEST_F(Overwriting, OfInputsIsRefusedByEveryCommand) {
  std::set<std::string> tried;
  for (const auto& command : commands())
    for (const auto& use : uses(command))
      for (const auto& output : use.outputs)
        for (const auto& path : use.read) {
          const auto names = spellings(path);
          for (std::size_t i = 0; i < names.size(); ++i) {
            // All spellings for one command; for the others, which share the rule, they take turns.
            if (command != "info" && i != tried.size() % names.size()) continue;
            expect_refused(line(use, {{output.name, names[i]}}), output.name);
            if (HasFatalFailure()) return;
          }
          tried.insert(command + output.name + path);
        }
  EXPECT_GT(tried.size(), 60u);
}

TEST_F(Overwriting, OfAnotherOutputIsRefusedByEveryCommand) {
  int pairs = 0;
  for (const auto& command : commands())
    for (const auto& use : uses(command))
      for (const auto& a : use.outputs)
        for (const auto& b : use.outputs) {
          if (!(a.name < b.name)) continue;
          expect_refused(line(use, {{a.name, "fresh/one"}, {b.name, "fresh/none/../one"}}), "--");
          if (HasFatalFailure()) return;
          ++pairs;
        }
  EXPECT_GE(pairs, 15);
  expect_refused("train scenes/scene.toml d.h5 -o fresh/m --json fresh/m/model.txt", "--json");
  expect_refused("precompute scenes/scene.toml -o fresh/d.h5 --json fresh/d.h5.log/j.json", "--json");
  expect_refused("export model -o fresh/c --name n --json fresh/c/n.bin", "--json");
  expect_refused("run scenes/scene.toml -o fresh/o --json fresh/o/model/mesh.txt", "--json");
  be_refused("mesh scenes/scene.toml -o ''");
}

TEST_F(Overwriting, EveryWrittenFileIsRefusedAsInput) {
  // The word @ is the input that is then replaced by each file that the command has written.
  const std::pair<const char*, const char*> cases[] = {
      {"run @ -o new", "scenes/scene.toml"},
      {"export @ -o new --golden 2", "model"},
      {"train @ d.h5 -o new", "scenes/scene.toml"},
      {"precompute @ -o new.h5", "scenes/scene.toml"},
      {"mesh @ -o new.msh --json new.json", "scenes/scene.toml"},
      {"validate @ model --probes 2 --json new.json", "scenes/scene.toml"}};
  for (const auto& [words, input] : cases) {
    const auto with = [&, command = std::string(words)](const std::string& given) {
      auto full = command;
      return full.replace(full.find('@'), 1, given);
    };
    const auto before = files();
    succeed(with(input));
    int written = 0;
    const auto after = files();
    for (const auto& [name, bytes] : after) {
      if (before.contains(name)) continue;
      ++written;
      expect_refused(with(name), "--");
      if (HasFatalFailure()) return;
    }
    EXPECT_GT(written, 0) << words;
    for (const auto& name : {"new", "new.h5", "new.msh", "new.json"}) fs::remove_all(folder / name);
  }
}

TEST_F(Overwriting, OfFilesThatAreNamedLaterIsRefused) {
  // Files beside a .pvd are numbered like the increments.
  fs::rename(folder / "d.h5", folder / "fresh/p-0001.vtu");
  expect_refused("show fresh/p-0001.vtu --node " + node + " --direction 0 -o fresh/p.pvd", "--output");
  // The mesh of a scene where `run` writes its own.
  auto text = read_file(folder / "scenes/scene.toml");
  text.replace(text.find("../parts/body.msh"), 17, "../out/mesh.msh");
  write_file(folder / "scenes/other.toml", text);
  fs::create_directory(folder / "out");
  fs::copy_file(folder / "parts/body.msh", folder / "out/mesh.msh");
  expect_refused("run scenes/other.toml -o scenes/../out", "--output");
  // A model in the folder of a database's logs.
  expect_refused("train scenes/scene.toml s.h5 -o s.h5.log", "--output");
  // Names under which files are written before they are renamed.
  for (const char* suffix : {".part", ".tmp", ".packing"}) {
    const auto scene = std::string("x") + suffix;
    fs::copy_file(folder / "block.toml", folder / scene);
    const bool is_text = scene == "x.part";
    expect_refused((is_text ? "mesh " : "precompute ") + scene + " -o x", "--output");
  }
}

// An output gets its name by being renamed: what another name of the file leads to stays.
TEST_F(Overwriting, LeavesOtherHardLinksAsTheyWere) {
  for (const auto& [words, input] :
       {std::pair{"mesh scenes/scene.toml -o ", "parts/body.msh"},
        std::pair{"precompute scenes/scene.toml -o ", "d.h5"}, std::pair{"info model --json ", "model/model.txt"}}) {
    const auto before = read_file(folder / input);
    for (const char* name : {"fresh/other", "fresh/other.part"}) {
      fs::create_hard_link(folder / input, folder / name);
      phynness(words + std::string("fresh/other"));
      EXPECT_EQ(read_file(folder / input), before) << words << name;
      fs::remove(folder / "fresh/other");
    }
  }
}

TEST_F(Overwriting, IsNotSeenWhereThereIsNone) {
  const auto eval = "eval model --node " + node + " --displacement 0,0,-0.001 ";
  fs::create_directory(folder / "alone");
  fs::copy_file(folder / "block.toml", folder / "alone/block.toml");
  for (const auto& words :
       {eval + "--json /dev/null --deformation /dev/null", eval + "--json fresh/a.json --deformation fresh/a.csv",
        std::string("mesh scenes/scene.toml -o scenes/scene.msh --json parts/body.json"),
        std::string("train scenes/scene.toml d.h5 -o . --json train.json"),
        std::string("export model -o . --json sizes.json"),
        std::string("run alone/block.toml -o alone --json run.json")}) {
    succeed(words);
  }
}

TEST_F(Overwriting, CannotBeDoneByAnOptionThatIsNotDeclared) {
  int n = 0;
  for (const auto& command : commands())
    for (const auto& use : uses(command))
      for (const auto& option : offered(command).of_type("TEXT")) {
        ++n;
        EXPECT_TRUE(texts.contains(option.name))
            << command << " " << option.name << ": declare it with add_path(), or list it here as a plain text";
        // Whatever the command makes of such a value, it does not write there.
        const auto before = files();
        phynness(line(use, {}) + " " + option.name + " scenes/scene.toml");
        for (const auto& [name, bytes] : before)
          ASSERT_EQ(read_file(folder / name), bytes) << command << " " << option.name << ": " << name;
      }
  EXPECT_GE(n, 15);
}

}  // namespace
}  // namespace phynness::test
