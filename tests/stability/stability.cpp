// stability [KERNEL...]: every kernel at its extremes, held against long double or closed forms, with the
// bound that theory gives. One row a case, as CSV, to standard output; status 1 if a bound is not kept.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <string>

#include "base/simd.h"
#include "kernels.h"

namespace {

struct Kernel {
  std::string name;
  void (*run)(vol::stability::Table&);
};
const Kernel kKernels[] = {
#define KERNEL(name) {#name, vol::stability::name},
#include "kernels.inc"
#undef KERNEL
};

}  // namespace

int main(int argc, char** argv) {
  for (int a = 1; a < argc; ++a) {
    bool known = false;
    for (const auto& kernel : kKernels) known = known || kernel.name == argv[a];
    if (known) continue;
    std::string names;
    for (const auto& kernel : kKernels) names += " " + kernel.name;
    std::cerr << "stability: no kernel \"" << argv[a] << "\", there are:" << names << '\n';
    return 2;
  }
  try {
    if (const char* most = std::getenv("PRECIS_SIMD")) vol::limit_simd(most);
  } catch (const std::exception& error) {
    std::cerr << "stability: " << error.what() << '\n';
    return 2;
  }
  bool kept = true;
  vol::stability::write_header(std::cout);
  for (const auto& kernel : kKernels) {
    bool asked = argc == 1;
    for (int a = 1; a < argc; ++a) asked = asked || kernel.name == argv[a];
    if (!asked) continue;
    vol::stability::Table table(kernel.name);
    try {
      kernel.run(table);
    } catch (const std::exception& error) {
      std::cerr << "stability: " << kernel.name << ": " << error.what() << '\n';
      return 2;
    }
    vol::stability::write_rows(std::cout, table.rows());
    for (const auto& row : table.rows()) kept = kept && row.outcome != "NOT KEPT";
    kept = kept && !table.rows().empty();
  }
  return kept ? 0 : 1;
}
