#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "base/result.h"
#include "render/camera.h"
#include "station/command_io.h"
#include "station/measure_pictures.h"

namespace annulus {

/// The options of `render` that make a picture that measures.
struct MeasurePictureFlags {
  std::string map;
  std::string range;  ///< "A,B"
  std::vector<std::string> scans;
  std::string against;
  std::string values;
  std::string tapes;  ///< "girths", "all" or "".
  bool landmarks = false;
  bool unrolled = false;
  std::string beside;
  std::string beside_worn;
  std::vector<std::string> beside_scans;
  std::string key_file;

  /// Whether one of them asks for such a picture instead of a likeness.
  [[nodiscard]] bool any() const {
    return !map.empty() || !tapes.empty() || landmarks || unrolled || !beside.empty() || !beside_worn.empty();
  }
};

/// Adds them to a command, in a group of their own.
void AddMeasurePictureOptions(CLI::App& command, MeasurePictureFlags& flags);

/// The part of `render`'s other options that they work with.
struct MeasurePictureRequest {
  std::string model;
  std::string worn;  ///< "" for none.
  View view;
  int size = 720;
  int turntable = 0;  ///< Frames; 0: one picture.
  int frame_ms = 80;  ///< Of a turntable's film.
  std::string out;    ///< PNG; of a turntable a folder or a file that ends in .webp.
};

/// Reads what the flags name, draws and writes. What was typed wrong sets exit code 2.
Status RunMeasurePicture(const MeasurePictureRequest& request, const MeasurePictureFlags& flags, CommandIo& io);

}  // namespace annulus
