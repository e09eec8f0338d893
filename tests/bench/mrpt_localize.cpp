// Times one update of MRPT's CMonteCarloLocalization2D, the filter of its program pf-localization: motion, likelihood
// field, systematic resampling.
// Input, little-endian: int32 rows, cols; f64 resolution, origin x, origin y; rows x cols f32 probabilities of being
// free; int32 beams; f64 first bearing, step of the bearings, greatest range; beams x f32 ranges, 0 for none; 3 f64
// place of the sensor in the base; 3 f64 motion; int32 particles; particles x 3 f64 poses; int32 repetitions.
// Prints the milliseconds of the best repetition. Each begins with the given particles.
#include <mrpt/bayes/CParticleFilter.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/slam/CMonteCarloLocalization2D.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <vector>

using namespace mrpt;

template <class T>
static std::vector<T> read(FILE* file, size_t count) {
  std::vector<T> out(count);
  if (fread(out.data(), sizeof(T), count, file) != count) throw std::runtime_error("the file ends early");
  return out;
}

int main(int, char** argv) {
  FILE* file = fopen(argv[1], "rb");
  if (!file) return 1;
  const auto size = read<int32_t>(file, 2);
  const auto place = read<double>(file, 3);
  const auto cells = read<float>(file, size_t(size[0]) * size[1]);
  auto map = maps::COccupancyGridMap2D::Create(
      place[1], place[1] + size[1] * place[0], place[2], place[2] + size[0] * place[0], place[0]);
  for (int row = 0; row < size[0]; row++)
    for (int col = 0; col < size[1]; col++) map->setCell(col, row, cells[size_t(row) * size[1] + col]);
  auto& field = map->likelihoodOptions;
  field.likelihoodMethod = maps::COccupancyGridMap2D::lmLikelihoodField_Thrun;
  field.LF_decimation = 1;
  field.LF_stdHit = 0.2f;
  field.LF_zHit = field.LF_zRandom = 0.5f;
  field.LF_maxCorrsDistance = 2.0f;

  const int beams = read<int32_t>(file, 1)[0];
  const auto angles = read<double>(file, 3);
  const auto ranges = read<float>(file, beams);
  const auto mount = read<double>(file, 3);
  auto scan = obs::CObservation2DRangeScan::Create();
  scan->aperture = float(angles[1] * (beams - 1));
  scan->rightToLeft = true;
  scan->maxRange = float(angles[2]);
  field.LF_maxRange = float(angles[2]);
  scan->sensorPose = poses::CPose3D(mount[0], mount[1], 0, mount[2] + angles[0] + 0.5 * scan->aperture, 0, 0);
  scan->resizeScan(beams);
  for (int k = 0; k < beams; k++) {
    scan->setScanRange(k, ranges[k]);
    scan->setScanRangeValidity(k, ranges[k] > 0);
  }
  obs::CSensoryFrame frame;
  frame.insert(scan);

  const auto moved = read<double>(file, 3);
  obs::CActionRobotMovement2D::TMotionModelOptions model;
  model.modelSelection = obs::CActionRobotMovement2D::mmThrun;
  obs::CActionRobotMovement2D motion;
  motion.computeFromOdometry(poses::CPose2D(moved[0], moved[1], moved[2]), model);
  obs::CActionCollection actions;
  actions.insert(motion);

  const int count = read<int32_t>(file, 1)[0];
  const auto given = read<double>(file, size_t(count) * 3);
  const int repetitions = read<int32_t>(file, 1)[0];
  slam::CMonteCarloLocalization2D filter(count);
  filter.options.metricMap = map;
  bayes::CParticleFilter runner;
  runner.m_options.PF_algorithm = bayes::CParticleFilter::pfStandardProposal;
  runner.m_options.resamplingMethod = bayes::CParticleFilter::prSystematic;
  runner.m_options.BETA = 2.0;  // resample after each update
  double best = 1e9;
  for (int i = 0; i < repetitions; i++) {
    for (int k = 0; k < count; k++) {
      filter.m_particles[k].d = math::TPose2D(given[3 * k], given[3 * k + 1], given[3 * k + 2]);
      filter.m_particles[k].log_w = 0;
    }
    const auto began = std::chrono::steady_clock::now();
    runner.executeOn(filter, &actions, &frame, nullptr);
    best = std::min(best, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count());
  }
  printf("%.4f\n", best);
}
