#pragma once

#include <string>

#include "base/clock.h"
#include "base/storage.h"
#include "station/config.h"
#include "station/console/route.h"

namespace annulus {

class BoothLink;
struct ConsoleFrame;
class JobRunner;
class KeySource;
class LiveHub;
class ModelCache;
class ScratchFolder;
class Store;

/// What the routes work with; all borrowed, all thread-safe, all living as long as the console.
struct ConsoleContext {
  const Config& config;
  std::string config_path;  ///< As it was given: "sim" or a file; jobs get the same.
  Store& store;
  BoothLink& booth;        ///< Orders to boothd, and its newest status (booth_link.h).
  LiveHub& live;           ///< Events to the browsers (live_hub.h).
  JobRunner& jobs;         ///< Long work in processes of its own (job_runner.h).
  ModelCache& models;      ///< Opened models for work at the speed of a hand (model_cache.h).
  ScratchFolder& scratch;  ///< Where opened files of customers may lie while they are worked on (scratch_folder.h).
  Storage& storage;
  const Clock& clock;
  const KeySource* station_keys = nullptr;  ///< Opens what boothd sealed; null: its recordings are plain.
};

// Each adds the routes of one area (docs/console_api.md has one section for each).
void AddSessionRoutes(RouteTable& table, ConsoleContext& context,
                      ConsoleFrame& frame);  ///< Log in and out, STOP, what the page needs first.
void AddCustomerRoutes(RouteTable& table, ConsoleContext& context);     ///< Customers, consents, erasure.
void AddBoothRoutes(RouteTable& table, ConsoleContext& context);        ///< Status, home, arm, start, acknowledge, jog.
void AddScanRoutes(RouteTable& table, ConsoleContext& context);         ///< Scans, models, measurements, documents.
void AddMeasureRoutes(RouteTable& table, ConsoleContext& context);      ///< Measuring by hand.
void AddGlassesRoutes(RouteTable& table, ConsoleContext& context);      ///< The designer.
void AddReshapeRoutes(RouteTable& table, ConsoleContext& context);      ///< Clay and elastic body.
void AddTechnicianRoutes(RouteTable& table, ConsoleContext& context);   ///< Doctor, drift, parameters, recordings.
void AddCalibrationRoutes(RouteTable& table, ConsoleContext& context);  ///< Guided calibration.
void AddReplayRoutes(RouteTable& table, ConsoleContext& context);       ///< The developer's replay and fits.
void AddAdminRoutes(RouteTable& table, ConsoleContext& context,
                    ConsoleFrame& frame);  ///< Users, retention, backups, audit.

}  // namespace annulus
