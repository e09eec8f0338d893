export interface Option<V extends string = string> {
  readonly value: V;
  readonly label: string;
}

interface SelectProps<V extends string> {
  /** The options, or names that are their own labels. */
  readonly options: readonly (Option<V> | V)[];
  readonly value: V;
  readonly id?: string;
  /** The id of what describes it. */
  readonly describedBy?: string | undefined;
  /** For screen readers, where no label is beside it. */
  readonly label?: string | undefined;
  readonly disabled?: boolean | undefined;
  readonly class?: string;
  readonly onChange: (value: V) => void;
}

/** A menu of which one option is chosen. */
export function Select<V extends string>({
  id,
  options,
  value,
  label,
  describedBy,
  disabled,
  class: more = "",
  onChange,
}: SelectProps<V>) {
  return (
    <select
      id={id}
      class={`select ${more}`.trim()}
      aria-label={label}
      aria-describedby={describedBy}
      value={value}
      disabled={disabled}
      onChange={(event) => onChange(event.currentTarget.value as V)}
    >
      {options.map((choice) => {
        const option = typeof choice === "string" ? { value: choice, label: choice } : choice;
        return (
          <option key={option.value} value={option.value} selected={option.value === value}>
            {option.label}
          </option>
        );
      })}
    </select>
  );
}

/** A menu below its label. */
export function SelectField<V extends string>({
  title,
  ...props
}: Omit<SelectProps<V>, "label"> & { readonly title: string }) {
  return (
    <label class="field">
      <span class="field-label">{title}</span>
      <Select {...props} />
    </label>
  );
}
