//! A SubDevice: controller, mailbox, objects and sensor.

use super::controller::Controller;
use super::datagram::Datagram;
use super::description::Description;
use super::dictionary::Dictionary;
use super::sensor::{Measurement, Sensor};
use super::states::AlState;
use super::{mailbox, sii};
use std::collections::VecDeque;

/// AL status code of a SubDevice whose application has failed (ETG.1000.6, table 11: unspecified error).
const UNSPECIFIED: u16 = 0x0001;

/// A SubDevice.
#[derive(Clone, Debug)]
pub struct SubDevice {
    about: Description,
    controller: Controller,
    objects: Dictionary,
    sensor: Sensor,
    answers: VecDeque<Vec<u8>>,
    /// The sample counter and the inputs stand still.
    pub stands: bool,
    /// It passes frames on and does not take part.
    pub deaf: bool,
}

impl SubDevice {
    /// A SubDevice that was just powered up.
    pub fn new(about: Description) -> Self {
        let bytes = |mapping| usize::from(sii::bits(mapping) / 8);
        let process_data = [bytes(&about.outputs), bytes(&about.inputs)];
        Self {
            controller: Controller::new(sii::content(&about), process_data),
            objects: Dictionary::new(&about),
            about,
            sensor: Sensor::default(),
            answers: VecDeque::new(),
            stands: false,
            deaf: false,
        }
    }

    /// Switches it off and on: it forgets all but what it is.
    pub fn restart(&mut self) {
        *self = Self::new(self.about.clone());
    }

    /// Its state.
    pub fn state(&self) -> AlState {
        self.controller.state()
    }

    /// Its counts per unit of force and torque.
    pub fn counts_per_unit(&self) -> (i32, i32) {
        self.about.counts_per_unit
    }

    /// What the MainDevice told it last.
    pub fn outputs(&self) -> &[u8] {
        self.controller.outputs()
    }

    /// Falls from OP to SAFE-OP with an error.
    pub fn fall_to_safe_op(&mut self) {
        if self.state() == AlState::Op {
            self.controller.fall(AlState::SafeOp, UNSPECIFIED);
        }
    }

    /// Removes an object.
    pub fn remove_object(&mut self, index: u16) {
        self.objects.remove(index);
    }

    /// Replaces a byte of its EEPROM. The index wraps around.
    pub fn spoil_eeprom(&mut self, at: usize, by: u8) {
        self.controller.spoil_sii(at, by);
    }

    /// Sends an emergency message as soon as the mailbox has room.
    pub fn send_emergency(&mut self) {
        self.answers.push_front(mailbox::emergency());
        self.deliver();
    }

    /// Takes a sample.
    pub fn measure(&mut self, measured: Measurement) {
        if !self.stands {
            self.sensor.measure(measured);
        }
    }

    pub(super) fn set_links(&mut self, onwards: bool) {
        self.controller.set_links(onwards);
    }

    /// Carries out a datagram as it passes.
    pub(super) fn process(&mut self, datagram: &mut Datagram<'_>) {
        if self.deaf {
            return;
        }
        if self.state() >= AlState::SafeOp {
            self.controller.set_inputs(&self.inputs());
        }
        self.controller.process(datagram);
        if let Some(request) = self.controller.request.take() {
            self.answers
                .extend(mailbox::answer(&request, &mut self.objects));
        }
        self.deliver();
    }

    /// The sensor's inputs, cut off or filled up to the length of the mapping.
    fn inputs(&self) -> Vec<u8> {
        let mut inputs = self.sensor.inputs().to_vec();
        inputs.resize(usize::from(sii::bits(&self.about.inputs) / 8), 0);
        inputs
    }

    fn deliver(&mut self) {
        if let Some(answer) = self.answers.front()
            && self.controller.answer(answer)
        {
            self.answers.pop_front();
        }
    }
}
