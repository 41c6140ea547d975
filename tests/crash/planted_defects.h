#pragma once

#include <memory>
#include <string>
#include <vector>

#include "subject.h"

namespace annulus::test {

/// A subject that is wrong in one way, which the properties must find.
struct PlantedDefect {
  std::string name;
  Subject subject;
};

/// Disks and files that do not do what they say.
std::vector<PlantedDefect> DefectiveDisks();
/// Readers that return what they should not, or less than they could, and recoveries that hide what was lost.
std::vector<PlantedDefect> DefectiveReaders();

/// A disk whose files say "written" while up to 64 KiB are in a buffer of the program. Borrows `below`.
std::unique_ptr<Storage> BufferingStorage(Storage& below);

}  // namespace annulus::test
