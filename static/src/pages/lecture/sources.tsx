import type { ComponentChildren } from "preact";

/** The lecture's sources, each written once: in full for the list at the end, and short for a section. */

export const SHORT = {
  "moravec-elfes": "Moravec and Elfes 1985",
  elfes: "Elfes 1989",
  "probabilistic-robotics": (
    <>
      <cite>Probabilistic Robotics</cite>
    </>
  ),
  "besl-mckay": "Besl and McKay 1992",
  censi: "Censi 2008",
  olson: "Olson 2009",
  hess: "Hess et al. 2016",
  ransac: "Fischler and Bolles 1981",
  montemerlo: "Montemerlo et al. 2002",
  gmapping: "Grisetti et al. 2007",
  grisetti: "Grisetti et al. 2010",
  zhang: "Zhang 1997",
  yang: "Yang et al. 2020",
  kuemmerle: "Kümmerle et al. 2009",
  bresenham: "Bresenham 1965",
  "amanatides-woo": "Amanatides and Woo 1987",
  octomap: "OctoMap 2013",
  "curless-levoy": "Curless and Levoy 1996",
  newcombe: "Newcombe et al. 2011",
  kerbl: "Kerbl et al. 2023",
  mildenhall: "Mildenhall et al. 2020",
  ieee754: "IEEE 754",
  "reflection-maps": "Hähnel et al. 2003",
  dellaert: "Dellaert et al. 1999",
  amcl: "Nav2 AMCL",
  "nav2-costmap": "Nav2 Costmap 2D",
  "nav2-inflation": "Nav2 Inflation Layer",
  "nav2-navfn": "Nav2 NavFn",
  "dijkstra-1959": "Dijkstra 1959",
  hart: "Hart et al. 1968",
  "slam-toolbox": "Macenski and Jambrecic 2021",
  "rep-103": "REP 103",
  "rep-105": "REP 105",
  "rep-117": "REP 117",
  "map-server": "Nav2 map_server",
  "laser-scan": "sensor_msgs/LaserScan",
  "occupancy-grid": "nav_msgs/OccupancyGrid",
} as const satisfies Readonly<Record<string, ComponentChildren>>;

export type SourceName = keyof typeof SHORT;

export const SOURCES: Readonly<Record<SourceName, ComponentChildren>> = {
  "moravec-elfes": (
    <>
      H. P. Moravec and A. Elfes, <cite>High resolution maps from wide angle sonar</cite>, IEEE International Conference
      on Robotics and Automation, 1985
    </>
  ),
  elfes: (
    <>
      A. Elfes, <cite>Using occupancy grids for mobile robot perception and navigation</cite>, Computer 22 (6), 1989
    </>
  ),
  "probabilistic-robotics": (
    <>
      S. Thrun, W. Burgard and D. Fox, <cite>Probabilistic Robotics</cite>, MIT Press, 2005
    </>
  ),
  "besl-mckay": (
    <>
      P. J. Besl and N. D. McKay, <cite>A method for registration of 3-D shapes</cite>, IEEE Transactions on Pattern
      Analysis and Machine Intelligence 14 (2), 1992
    </>
  ),
  censi: (
    <>
      A. Censi, <cite>An ICP variant using a point-to-line metric</cite>, IEEE International Conference on Robotics and
      Automation, 2008
    </>
  ),
  olson: (
    <>
      E. B. Olson, <cite>Real-time correlative scan matching</cite>, IEEE International Conference on Robotics and
      Automation, 2009
    </>
  ),
  hess: (
    <>
      W. Hess, D. Kohler, H. Rapp and D. Andor, <cite>Real-time loop closure in 2D LIDAR SLAM</cite>, IEEE International
      Conference on Robotics and Automation, 2016
    </>
  ),
  ransac: (
    <>
      M. A. Fischler and R. C. Bolles,{" "}
      <cite>
        Random sample consensus: a paradigm for model fitting with applications to image analysis and automated
        cartography
      </cite>
      , Communications of the ACM 24 (6), 1981
    </>
  ),
  montemerlo: (
    <>
      M. Montemerlo, S. Thrun, D. Koller and B. Wegbreit,{" "}
      <cite>FastSLAM: a factored solution to the simultaneous localization and mapping problem</cite>, AAAI National
      Conference on Artificial Intelligence, 2002
    </>
  ),
  gmapping: (
    <>
      G. Grisetti, C. Stachniss and W. Burgard,{" "}
      <cite>Improved techniques for grid mapping with Rao-Blackwellized particle filters</cite>, IEEE Transactions on
      Robotics 23 (1), 2007
    </>
  ),
  grisetti: (
    <>
      G. Grisetti, R. Kümmerle, C. Stachniss and W. Burgard, <cite>A tutorial on graph-based SLAM</cite>, IEEE
      Intelligent Transportation Systems Magazine 2 (4), 2010
    </>
  ),
  zhang: (
    <>
      Z. Zhang, <cite>Parameter estimation techniques: a tutorial with application to conic fitting</cite>, Image and
      Vision Computing 15 (1), 1997
    </>
  ),
  yang: (
    <>
      H. Yang, P. Antonante, V. Tzoumas and L. Carlone,{" "}
      <cite>
        Graduated non-convexity for robust spatial perception: from non-minimal solvers to global outlier rejection
      </cite>
      , IEEE Robotics and Automation Letters, 2020
    </>
  ),
  kuemmerle: (
    <>
      R. Kümmerle et al., <cite>On measuring the accuracy of SLAM algorithms</cite>, Autonomous Robots 27 (4), 2009
    </>
  ),
  bresenham: (
    <>
      J. E. Bresenham, <cite>Algorithm for computer control of a digital plotter</cite>, IBM Systems Journal 4 (1), 1965
    </>
  ),
  "amanatides-woo": (
    <>
      J. Amanatides and A. Woo, <cite>A fast voxel traversal algorithm for ray tracing</cite>, Eurographics 1987
    </>
  ),
  octomap: (
    <>
      A. Hornung et al., <cite>OctoMap: an efficient probabilistic 3D mapping framework based on octrees</cite>,
      Autonomous Robots 34, 2013
    </>
  ),
  "curless-levoy": (
    <>
      B. Curless and M. Levoy, <cite>A volumetric method for building complex models from range images</cite>, SIGGRAPH
      1996
    </>
  ),
  newcombe: (
    <>
      R. A. Newcombe et al., <cite>KinectFusion: real-time dense surface mapping and tracking</cite>, IEEE International
      Symposium on Mixed and Augmented Reality, 2011
    </>
  ),
  kerbl: (
    <>
      B. Kerbl, G. Kopanas, T. Leimkühler and G. Drettakis,{" "}
      <cite>3D Gaussian splatting for real-time radiance field rendering</cite>, ACM Transactions on Graphics 42 (4),
      2023
    </>
  ),
  mildenhall: (
    <>
      B. Mildenhall et al., <cite>NeRF: representing scenes as neural radiance fields for view synthesis</cite>,
      European Conference on Computer Vision, 2020
    </>
  ),
  ieee754: (
    <>
      <cite>IEEE Standard for Floating-Point Arithmetic</cite>, IEEE 754
    </>
  ),
  "reflection-maps": (
    <>
      D. Hähnel, R. Triebel, W. Burgard and S. Thrun,{" "}
      <cite>Map building with mobile robots in dynamic environments</cite>, IEEE International Conference on Robotics
      and Automation, 2003
    </>
  ),
  dellaert: (
    <>
      F. Dellaert, D. Fox, W. Burgard and S. Thrun, <cite>Monte Carlo localization for mobile robots</cite>, IEEE
      International Conference on Robotics and Automation, 1999
    </>
  ),
  amcl: (
    <>
      Nav2, <cite>AMCL</cite>: the documentation of its parameters
    </>
  ),
  "nav2-costmap": (
    <>
      Nav2, <cite>Costmap 2D</cite>: the documentation of the layers and their parameters
    </>
  ),
  "nav2-inflation": (
    <>
      Nav2, <cite>Inflation Layer Parameters</cite>, and computeCost in inflation_layer.hpp
    </>
  ),
  "nav2-navfn": (
    <>
      Nav2, <cite>nav2_navfn_planner</cite>: navfn.hpp and navfn.cpp
    </>
  ),
  "dijkstra-1959": (
    <>
      E. W. Dijkstra, <cite>A note on two problems in connexion with graphs</cite>, Numerische Mathematik 1, 1959
    </>
  ),
  hart: (
    <>
      P. E. Hart, N. J. Nilsson and B. Raphael,{" "}
      <cite>A formal basis for the heuristic determination of minimum cost paths</cite>, IEEE Transactions on Systems
      Science and Cybernetics 4 (2), 1968
    </>
  ),
  "slam-toolbox": (
    <>
      S. Macenski and I. Jambrecic, <cite>SLAM Toolbox: SLAM for the dynamic world</cite>, Journal of Open Source
      Software 6 (61), 2021
    </>
  ),
  "rep-103": (
    <>
      REP 103, <cite>Standard units of measure and coordinate conventions</cite>
    </>
  ),
  "rep-105": (
    <>
      REP 105, <cite>Coordinate frames for mobile platforms</cite>
    </>
  ),
  "rep-117": (
    <>
      REP 117, <cite>Informational distance measurements</cite>
    </>
  ),
  "map-server": (
    <>
      Nav2, <cite>nav2_map_server</cite>: the map files, their modes and thresholds
    </>
  ),
  "laser-scan": (
    <>
      ROS, message definition <cite>sensor_msgs/LaserScan</cite>
    </>
  ),
  "occupancy-grid": (
    <>
      ROS, message definition <cite>nav_msgs/OccupancyGrid</cite>
    </>
  ),
};
