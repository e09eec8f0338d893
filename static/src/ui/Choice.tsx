import { useId } from "preact/hooks";
import { type Option, Select } from "./Select";
import { Tooltip } from "./Tooltip";

interface ChoiceProps<V extends string> {
  readonly label: string;
  readonly options: readonly Option<V>[];
  readonly value: V;
  readonly sentence?: string;
  readonly disabled?: boolean;
  /** Hide the label visually, where the context already states it. */
  readonly bare?: boolean;
  readonly onChange: (value: V) => void;
}

/** A choice of one option: radio buttons in a row if the options are few and short, otherwise a select. */
export function Choice<V extends string>({
  label,
  options,
  value,
  sentence,
  disabled = false,
  bare = false,
  onChange,
}: ChoiceProps<V>) {
  const id = useId();
  const described = sentence ? { "aria-describedby": `${id}-description` } : {};
  const segmented = options.length <= 4 && options.reduce((n, option) => n + option.label.length, 0) <= 44;
  return (
    <div class="field" {...(segmented ? { role: "radiogroup", "aria-labelledby": `${id}-label`, ...described } : {})}>
      <span class={bare ? "visually-hidden" : "field-label"}>
        {segmented ? <span id={`${id}-label`}>{label}</span> : <label for={id}>{label}</label>}
        {sentence && <Tooltip id={`${id}-description`} text={sentence} about={label} />}
      </span>
      {segmented ? (
        <span class="choice">
          {options.map((option) => (
            <label class="choice-option" key={option.value}>
              <input
                type="radio"
                name={id}
                value={option.value}
                checked={option.value === value}
                disabled={disabled}
                onChange={() => onChange(option.value)}
              />
              {option.label}
            </label>
          ))}
        </span>
      ) : (
        <Select
          id={id}
          describedBy={described["aria-describedby"]}
          value={value}
          options={options}
          disabled={disabled}
          onChange={onChange}
        />
      )}
    </div>
  );
}
