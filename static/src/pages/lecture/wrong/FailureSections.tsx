/** Faults of maps of real buildings, each section with its scene. */

import { SideView } from "../../../lessons/heights/SideView";
import { peopleOn, peopleScans, polishedOn } from "../../../lessons/stage/controls";
import { bound } from "../../../ui/bound";
import { Slider } from "../../../ui/Slider";
import { ToggleOf } from "../../../ui/Toggle";
import { OnStage, Section, type SectionHead, SectionLink } from "../Section";

export function PolishedSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="polished" label="A polished wall and the map of it">
          <div class="stage-row">
            <ToggleOf label="polished wall" signal={polishedOn} />
          </div>
        </OnStage>
      }
      sources={[["probabilistic-robotics", "section 6.3"]]}
      after={
        <p>
          Glass, polished metal and stone do the same. Where a beam does come back by way of another surface, it reports
          too long a distance, and the cells of the wall count as passed; with hits from in front their values{" "}
          <b>oscillate</b>. More readings do not help; another kind of sensor does.
        </p>
      }
    >
      <p>
        A laser measures a surface by the light that it scatters back. A <b>polished</b> wall is a mirror: unless the
        beam meets it almost at a right angle, usually nothing comes back (
        <SectionLink to="no-return" />
        ), and the wall is missing wherever the robot never stood in front of it.
      </p>
    </Section>
  );
}

export function PeopleSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="people" label="Someone walks behind the robot">
          <div class="stage-row">
            <ToggleOf label="someone walks" signal={peopleOn} />
            <Slider
              label="Scans of the drive"
              sentence="Number of scans in the map; the person follows the robot from scan 24 to scan 33."
              {...bound(peopleScans)}
              initial={32}
              low={24}
              high={77}
              step={1}
            />
          </div>
        </OnStage>
      }
      sources={["reflection-maps"]}
      after={
        <p>
          A trail stays where no later beams pass. Robots among people therefore keep a static map and, on top of it, a
          layer of current readings that is cleared continuously: in Nav2 the static and the obstacle layer (
          <SectionLink to="layers" />
          ).
        </p>
      }
    >
      <p>
        Someone who follows the robot is measured at a new place in every scan and leaves a <b>trail</b> of occupied
        cells. When the robot looks at the corridor again from elsewhere, its beams clear most of it
        <span class="no-print"> (move the slider)</span>.
      </p>
    </Section>
  );
}

export function LowTableSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="low-table" label="A table below the plane of the laser">
          <SideView />
        </OnStage>
      }
      sources={["octomap"]}
      after={
        <p>
          A cell has no height: the height of the laser decides which obstacles are in the map. A three-dimensional map
          stores it (
          <SectionLink to="octree" />
          ).
        </p>
      }
    >
      <p>
        A planar laser measures at the height of its mount. A lower table appears in no reading: the map is right about
        what the laser saw, and wrong about where the robot can drive.{" "}
        <span class="no-print">
          Drag the <b class="noun-beam">laser</b> up and down.
        </span>
      </p>
    </Section>
  );
}
