#!/bin/bash
# Claim: the runtime builds from its own folder, installs, and external programs in C and C++17, the latter without
# exceptions, find and use it, static and shared, by CMake and by pkg-config, also after the installation was moved. A status of the C++ wrapper
# that is overlooked does not compile. Every header that is installed compiles alone: none includes one that is not.
# Usage: builds_alone_and_installs.sh CMAKE RUNTIME_SOURCE CONSUMER_SOURCE WORK_DIR
set -euo pipefail
cmake=$1 runtime=$2 consumer=$3 work=$4
command -v make > /dev/null || export CMAKE_GENERATOR=Ninja
# Without optimization: what is claimed does not depend on it, and the compilation takes a third of the time.
export CMAKE_BUILD_TYPE=None
rm -rf "$work"
"$cmake" -S "$runtime" -B "$work/runtime" -DCMAKE_INSTALL_PREFIX="$work/prefix" > "$work.log"
"$cmake" --build "$work/runtime" >> "$work.log"
"$cmake" --install "$work/runtime" >> "$work.log"
for header in "$work"/prefix/include/phynness/*; do
  [[ $header == *.h* ]] || { echo "not a header for devices: $header"; exit 1; }
  "${CXX:-c++}" -std=c++17 -fsyntax-only -I"$work/prefix/include" -x c++ "$header" -w
done
for file in phynness_image.h phynness_image.cpp; do
  cmp "$work/runtime/image/$file" "$work/prefix/share/phynness/image/$file"
done
"$cmake" -S "$consumer" -B "$work/consumer" -DCMAKE_PREFIX_PATH="$work/prefix" >> "$work.log"
"$cmake" --build "$work/consumer" >> "$work.log"
"$work/consumer/c_consumer" "$runtime/../examples/model/model.txt"
"$work/consumer/cpp_consumer"
"$work/consumer/shared_consumer" "$runtime/../examples/model/model.txt"
# The lines for CMake of docs/howto/embed.md, with the program of examples/minimal.
mkdir "$work/page"
cp "$runtime/../examples/minimal/main.c" "$work/page"
sed -n '/^    cmake_minimum_required/,/^$/p' "$runtime/../docs/howto/embed.md" > "$work/page/CMakeLists.txt"
"$cmake" -S "$work/page" -B "$work/page/build" -DCMAKE_PREFIX_PATH="$work/prefix" >> "$work.log"
"$cmake" --build "$work/page/build" >> "$work.log"
"$work/page/build/my_device" "$runtime/../examples/model/model.txt" 95 0 0 -0.01 > /dev/null
# The programs of that page: its C finds the sample model or refuses a text that is no model or body, its C++ says which
# file it lacks.
page_program() { sed -n "/^    #include <phynness\/phynness$1>/,/^    }$/p" "$runtime/../docs/howto/embed.md"; }
page_program .h > "$work/page/page.c"
page_program .hpp > "$work/page/page.cpp"
page_program _body.h > "$work/page/body.c"
library=("-I$work/prefix/include" "$(find "$work/prefix" -name libphynness_runtime.a)")
"${CC:-cc}" -std=c99 -Wall -Wextra -Wpedantic -Werror "$work/page/page.c" "${library[@]}" -lm -o "$work/page/c"
"${CC:-cc}" -std=c99 -Wall -Wextra -Wpedantic -Werror "$work/page/body.c" "${library[@]}" -lm -o "$work/page/body"
"${CXX:-c++}" -std=c++17 -fno-exceptions -Wall -Wextra -Werror "$work/page/page.cpp" "${library[@]}" -o "$work/page/cpp"
said=$("$work/page/c" "$runtime/../examples/model/model.txt")
[[ $said == *"N: success"*"at most "*" N off" ]]
said=$("$work/page/c" "$runtime/../LICENSE") || [[ $said == "byte 1: this is not a phynness model"* ]]
said=$("$work/page/body" "$runtime/../LICENSE") || [[ $said == "byte 1: "* ]]
said=$(cd "$work/page" && ./cpp) || [[ $said == "out/demo/model: "* ]]
# The example of a haptic loop, outside of the repository, against what is installed.
cp -r "$runtime/../examples/haptic_loop" "$work/haptic_loop"
"$cmake" -S "$work/haptic_loop" -B "$work/haptic_build" -DCMAKE_PREFIX_PATH="$work/prefix" >> "$work.log"
"$cmake" --build "$work/haptic_build" >> "$work.log"
said=$("$work/haptic_build/haptic_loop" 2>&1) || [[ $said == *MODEL_DIR* ]]
mv "$work/prefix" "$work/moved"
folder=$(dirname "$(find "$work/moved" -name phynness.pc)")
if ! command -v pkg-config > /dev/null; then
  echo "no pkg-config here: its half of the claim is not checked; tools/install-deps installs it"
  exit 0
fi
export PKG_CONFIG_PATH=$folder
[ "$(pkg-config --modversion phynness)" = "$(pkg-config --modversion phynness-image)" ]
read -ra flags <<< "$(pkg-config --cflags --libs phynness phynness-image)"
"${CC:-cc}" -std=c99 -Wall -Wextra -Wpedantic -Werror "$consumer/c_consumer.c" "${flags[@]}" -lm -o "$work/by_pkg_config"
"$work/by_pkg_config"
for standard in c++17 c++20; do
  cpp=("${CXX:-c++}" -std=$standard -fno-exceptions -fno-rtti -Wall -Wextra -Wpedantic -Wconversion -Werror)
  "${cpp[@]}" "$consumer/cpp_consumer.cpp" "${flags[@]}" -o "$work/by_pkg_config"
  "$work/by_pkg_config"
  if "${cpp[@]}" -DOVERLOOK -fsyntax-only "$consumer/cpp_consumer.cpp" "${flags[@]}" 2> "$work/overlooked.log"; then
    echo "an overlooked status compiles"
    exit 1
  fi
  grep -q nodiscard "$work/overlooked.log"
  # Headers of Windows define these words as macros.
  { printf '#include <%s>\n' algorithm array cmath cstdio memory mutex string string_view thread utility vector span
    printf '#define %s\n' near far 'min(a, b) ((a) < (b) ? (a) : (b))' 'max(a, b) ((a) < (b) ? (b) : (a))'
    printf '#include <phynness/%s>\n' phynness_batch.hpp phynness_loop.h phynness_image.h phynness_surface.h
  } > "$work/macros.cpp"
  [ $standard = c++20 ] || sed -i '/<span>/d' "$work/macros.cpp"
  "${cpp[@]}" -Wno-variadic-macros -fexceptions -fsyntax-only "$work/macros.cpp" "${flags[@]}"
done
