import { Button } from "../../ui/Button";
import { bound } from "../../ui/bound";
import { Choice } from "../../ui/Choice";
import { Slider } from "../../ui/Slider";
import { looked, type Place, placeOfTable, since, tableLifetime, walkerAt } from "./state";
import "./navigation.css";

const PLACES = [
  { value: "static", label: "the map" },
  { value: "obstacle", label: "obstacles" },
  { value: "dynamic", label: "lifetime" },
];
const [GONE_FOR, LIVES] = [12, 20];
const START = walkerAt.peek();

/** Where the table is remembered, and for how long. */
export function Lifetime() {
  return (
    <div class="lifetime-controls figure-controls no-print">
      <Choice
        label="The table is in"
        options={PLACES}
        value={placeOfTable.value}
        sentence="Which part of the costmap has the table that was seen."
        onChange={(value) => {
          placeOfTable.value = (PLACES.find((place) => place.value === value)?.value ?? "static") as Place;
          looked.value = [];
        }}
      />
      <Slider
        label="Time since its removal"
        sentence="Seconds since the table was taken away; 0: it is still there."
        value={since.value}
        initial={GONE_FOR}
        low={0}
        high={60}
        step={1}
        unit="s"
        onInput={(value) => {
          since.value = value;
          if (value === 0) looked.value = [];
        }}
      />
      <Slider
        label="Obstacle lifetime"
        sentence="Seconds after which an obstacle that is not seen again is forgotten."
        {...bound(tableLifetime)}
        initial={LIVES}
        low={1}
        high={60}
        step={1}
        unit="s"
        disabled={placeOfTable.value !== "dynamic"}
      />
      <Button
        icon="restart"
        onClick={() => {
          looked.value = [];
          walkerAt.value = START;
          since.value = GONE_FOR;
          tableLifetime.value = LIVES;
        }}
      >
        Reset
      </Button>
    </div>
  );
}
