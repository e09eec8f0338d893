/** Costmaps and paths, each section with its scene. */

import { LaterFigure, OnStage, Section, type SectionHead, SectionLink } from "../Section";

export function LayersSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="layers" label="The layers of a costmap">
          <LaterFigure id="layers" />
        </OnStage>
      }
      sources={["nav2-costmap"]}
      after={
        <p>
          The <b>obstacle layer</b> marks where the beams of the current scan end, and clears what they pass. It cannot
          clear a wall of the static layer, whose cost is greater. The <b>dynamic layer</b> removes what has not been
          seen for some time, for Nav2 the spatio-temporal voxel layer, a plugin.
        </p>
      }
    >
      <p>
        A map says what is occupied; a planner needs the <b>cost</b> of driving through each cell. In Nav2’s costmap 0
        is free, 254 is lethal, 253 means a collision at any heading, 255 is unknown. It is made of <b>layers</b>, the
        saved map first, and the greatest known cost counts.{" "}
        <span class="no-print">Drag the crate into view, switch layers off, and read the costs under the cross.</span>
      </p>
    </Section>
  );
}

export function InflationSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="inflation" label="The inflation of a costmap">
          <LaterFigure id="inflation" />
        </OnStage>
      }
      sources={["nav2-inflation"]}
      after={
        <p>
          A <b>larger</b> cost_scaling_factor makes the cost fall <b>faster</b>, so paths come closer to walls. A door
          narrower than twice the inscribed radius is closed in any case.
        </p>
      }
    >
      <p>
        A planner on a grid treats the robot as a point. <b>Inflation</b> makes up for that: around each lethal cell the
        cost is 253 up to the <b>inscribed radius</b>, where the robot collides at any heading; beyond it the cost falls
        exponentially and ends at the <b>inflation radius</b>.{" "}
        <span class="no-print">
          Drag the curve by its point for cost_scaling_factor, by its foot for inflation_radius.
        </span>
      </p>
    </Section>
  );
}

export function PathSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="path" label="The search for a path">
          <LaterFigure id="path" />
        </OnStage>
      }
      sources={["dijkstra-1959", "hart", "nav2-navfn"]}
      after={
        <p>
          <b>Dijkstra’s algorithm</b> expands the cell with the least cost so far. <b>A*</b> adds an estimate of the
          cost to go that is never too high, here the distance times the cost of a free cell, and expands fewer cells
          for a path of equal cost.
        </p>
      }
    >
      <p>
        A path is found by a <b>wavefront</b>: from the robot’s cell outwards, each cell gets the least cost of reaching
        it, its <b>potential</b>. A step costs 50 + 0.8 · cost of the cell, as in Nav2’s NavFn. A diagonal step costs √2
        times that here; NavFn has no diagonal steps, and interpolates between two neighbours. Lethal and inscribed
        cells are blocked. The path is traced back from the goal.{" "}
        <span class="no-print">
          Drag the <b>goal</b>.
        </span>
      </p>
    </Section>
  );
}

export function LifetimeSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="lifetime" label="A path round a table that is gone">
          <LaterFigure id="lifetime" />
        </OnStage>
      }
      sources={["nav2-costmap"]}
      after={
        <p>
          Too short a lifetime: a person out of view for a moment is removed although still there. Too long: the robot
          drives around something that is gone.
        </p>
      }
    >
      <p>
        As in <SectionLink to="forgetting" />, a table has been removed, and the path still goes around it: only a beam
        clears an obstacle, and a robot that plans around it may never look there. In the <b>saved map</b> the table
        stays for good. In the <b>obstacle layer</b> it stays until a beam passes
        <span class="no-print"> (drag the robot towards it)</span>. With a <b>lifetime</b> it is removed after a set
        time.
      </p>
    </Section>
  );
}

export function StackSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="stack" label="SLAM, the saved map, localization and navigation in one picture">
          <LaterFigure id="stack" />
        </OnStage>
      }
      sources={["slam-toolbox", "amcl", "nav2-costmap"]}
      after={
        <p>
          Each part relies on the one before: double walls give poor weights, a wrong pose closes doors, a table in the
          saved map is avoided for good. When a robot does not find its way, check them in this order.
        </p>
      }
    >
      <p>
        All parts together, as on a robot with <b>SLAM Toolbox</b> and <b>Nav2</b>: one drive makes the map; on another
        day the robot uses it. <span class="no-print">Drag the goal, or play all of it.</span>
      </p>
    </Section>
  );
}
