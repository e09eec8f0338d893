/** What goes wrong with maps of real buildings, each with its scene. */

import { SideView } from "../../lessons/heights/SideView";
import { peopleOn, peopleScans, polishedOn } from "../../lessons/stage/controls";
import { Slider } from "../../ui/Slider";
import { ToggleOf } from "../../ui/Toggle";
import { OnStage } from "./OnStage";
import { Section, type SectionHead } from "./Section";
import { SectionLink } from "./SectionLink";

export function PolishedSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="polished" label="A polished wall and the map of it">
          <div class="stage-row">
            <ToggleOf label="polished wall" signal={polishedOn} />
          </div>
        </OnStage>
      }
      sources={[["probabilistic-robotics", "chapter 6: failures, of which specular reflection is a cause"]]}
      after={
        <p>
          Glass and polished metal or stone do the same. A beam that is reflected to another surface and back reports a
          distance that is too long, and the cells of the wall count as passed: their values <b>oscillate</b>. More
          readings do not help; another kind of sensor does, or a strip of tape on the glass.
        </p>
      }
    >
      <p>
        A laser measures a surface by the light that the surface scatters back. A <b>polished</b> wall reflects it like
        a mirror: unless the beam meets it almost at a right angle, nothing comes back to the sensor. For the mapper
        such a beam has no return (<SectionLink to="no-return" />
        ), and the wall is missing wherever the robot never stood in front of it.
      </p>
    </Section>
  );
}

export function PeopleSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="people" label="Someone walks behind the robot">
          <div class="stage-row">
            <ToggleOf label="someone walks" signal={peopleOn} />
            <Slider
              label="Scans of the drive"
              sentence="Number of scans in the map; the person follows the robot from scan 24 to scan 33."
              value={peopleScans.value}
              initial={32}
              low={24}
              high={77}
              step={1}
              onInput={(value) => {
                peopleScans.value = value;
              }}
            />
          </div>
        </OnStage>
      }
      sources={[["reflection-maps", "for maps of places with people"]]}
      after={
        <p>
          A trail disappears where later beams pass, and stays where none do. Robots that work among people therefore
          keep two maps: a static one, and on top of it a layer of the current readings that is cleared continuously. In
          Nav2 these are the static layer and the obstacle layer of its costmap.
        </p>
      }
    >
      <p>
        The second assumption says that the world does not change. Someone who follows the robot is measured at a new
        place in every scan, and leaves a <b>trail</b> of occupied cells, which the person hides from the next scan.
        Move the slider: when the robot looks at the corridor again from elsewhere, its beams clear most of the trail.
      </p>
    </Section>
  );
}

export function LowTableSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={
        <OnStage scene="low-table" label="A table below the plane of the laser">
          <SideView />
        </OnStage>
      }
      sources={[["octomap", "for maps with height"]]}
      after={
        <p>
          A cell has no height: a low table, a high table and a wall project onto the same cells. Which obstacles are in
          the map depends on the height at which the laser is mounted. A three-dimensional map, for example OctoMap’s
          tree of cells, stores height and needs more memory and time.
        </p>
      }
    >
      <p>
        A planar laser measures in one plane, at the height of its mount. A table that is lower than this plane is not
        in any reading. The map is correct about what the laser saw, and wrong about where the robot can drive. Drag the{" "}
        <b class="noun-beam">laser</b> up and down.
      </p>
    </Section>
  );
}
