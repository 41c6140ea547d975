#include "fitting/calibrate_ring.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "ring_rig.h"

namespace annulus::test {
namespace {

TEST(CalibrateRing, Study) {
  for (std::uint64_t seed = std::getenv("S0") ? std::atoi(std::getenv("S0")) : 1,
                     last = seed + (std::getenv("SN") ? std::atoi(std::getenv("SN")) : 2);
       seed < last; ++seed) {
    const RingCalibration truth = sim::RandomRing(600.0, {}, seed);
    const auto rig = TwoCylinders(seed);
    std::vector<CalibrationTarget> targets{rig[0].target, rig[1].target};
    std::vector<TargetScan> scans;
    const auto plan = EightPlacements(seed);
    RigOptions rig_options;
    CalibrateOptions options;
    if (std::getenv("WIDE")) {
      options.tolerances.position_mm *= 4;
      options.tolerances.aim_rad *= 4;
      options.tolerances.offset_mm *= 4;
      options.tolerances.scale *= 4;
    }
    if (std::getenv("NARROW")) {
      options.tolerances.position_mm /= 3;
      options.tolerances.aim_rad /= 3;
      options.tolerances.offset_mm /= 3;
      options.tolerances.scale /= 3;
    }

    if (const char* n = std::getenv("NOISE")) rig_options.noise_mm = std::atof(n);
    if (std::getenv("NOOUT")) rig_options.outlier_rate = rig_options.dropout_rate = 0;
    if (const char* n = std::getenv("PITCH")) rig_options.pitch_mm = std::atof(n);
    for (std::size_t k = 0; k < plan.size(); ++k) {
      scans.push_back(ScanTarget(truth, rig[plan[k].target], plan[k], k, rig_options, seed));
    }
    const auto solution =
        CalibrateRing(std::getenv("TRUTH") ? truth : RingCalibration::Ideal(600.0), targets, scans, options, {});
    ASSERT_TRUE(solution) << solution.error().Text();
    std::printf("%s q=%d\n", solution->BriefReport().c_str(), solution->quadratic);
    for (const auto& p : solution->placements) {
      std::printf("  %s off %.1f tilt %.2f rms %.3f -> %.4f noise %.3f rej %zu else %zu used %zu motion %.3f (%.3f)\n",
                  p.name.c_str(), p.off_centre_mm, DegreesFromRadians(p.tilt_rad), p.rms_before_mm, p.rms_after_mm,
                  p.noise_mm, p.rejected, p.elsewhere, p.readings, p.motion.largest_mm, p.motion.sigma_mm);
    }
    for (const auto& t : solution->targets) {
      std::printf("  target %.3f found %.4f miss %.4f (%.4f) oor %.3f\n", t.certified_radius_mm, t.form.radius_mm,
                  t.radius_miss_mm, t.radius_miss_sigma_mm, t.out_of_round_mm);
    }
    for (const auto& o : solution->observability) {
      std::printf("  %-44s %.4g -> %.4g %s\n", o.name.c_str(), o.prior_sd, o.posterior_sd,
                  o.observable ? "" : "UNOBSERVABLE");
    }
    for (const auto& f : solution->findings) std::printf("  FINDING %s: %s\n", f.code.c_str(), f.text.c_str());
    for (const auto& b : solution->budget)
      std::printf("  budget %-40s %.3f mm %.3f %%\n", b.name.c_str(), b.girth_mm, b.volume_percent);
    for (double d = 250.0; d <= 550.0; d += 50.0) {
      const RigErrors e = ErrorsAt(truth, solution->calibration, d);
      std::printf("  at %.0f: common %+.4f (sd %.4f) sensors %.4f lateral %.4f deg vertical %.4f deg\n", d, e.common_mm,
                  solution->common_sigma_mm[static_cast<int>((d - 250) / 50)], e.sensor_rms_mm,
                  DegreesFromRadians(e.lateral_rms_mm / d), DegreesFromRadians(e.vertical_rms_mm / d));
    }
  }
}

}  // namespace
}  // namespace annulus::test
