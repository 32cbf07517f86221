// A robot base on Fast DDS, as a ROS 2 node sees the wire: an implementation of DDS that shares no
// code with CycloneDDS. It takes `geometry_msgs/Twist` (or TwistStamped) and publishes
// `nav_msgs/Odometry`.
//
// usage: fastdds_base DOMAIN TOPIC twist|stamped reliable|best_effort
//
// It writes "matched N" for each change of publishers, and for each message
// "twist MONOTONIC_NS STAMP_NS LINEAR_X ANGULAR_Z OTHERS", where OTHERS is the sum of what must be
// zero. A line "odometry X Y QZ QW V W" on its input publishes that, "parameter NODE NAME VALUE"
// makes it answer for a node's parameter, as Fast DDS's layer of ROS 2 does. It ends with its input.
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

using namespace eprosima::fastdds::dds;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using eprosima::fastrtps::rtps::IPLocator;
using eprosima::fastrtps::rtps::Locator_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

namespace {

struct Header {
    int32_t sec = 0;
    uint32_t nanosec = 0;
    std::string frame;
    void put(Cdr& cdr) const { cdr << sec << nanosec << frame; }
    void get(Cdr& cdr) { cdr >> sec >> nanosec >> frame; }
};

struct Twist {
    bool stamped = false;
    Header header;
    double six[6] = {};
    void put(Cdr& cdr) const {
        if (stamped) header.put(cdr);
        for (double part : six) cdr << part;
    }
    void get(Cdr& cdr) {
        if (stamped) header.get(cdr);
        for (double& part : six) cdr >> part;
    }
};

struct Odometry {
    Header header;
    std::string child = "base_link";
    double pose[7] = {};
    double twist[6] = {};
    double covariance[36] = {};
    void put(Cdr& cdr) const {
        header.put(cdr);
        cdr << child;
        for (double part : pose) cdr << part;
        for (double part : covariance) cdr << part;
        for (double part : twist) cdr << part;
        for (double part : covariance) cdr << part;
    }
    void get(Cdr&) { std::abort(); }  // it only publishes it
};

struct Asked {
    std::vector<std::string> names;
    void put(Cdr& cdr) const { cdr << names; }
    void get(Cdr& cdr) { cdr >> names; }
};

struct Answered {
    std::vector<double> numbers;
    void put(Cdr& cdr) const {
        cdr << static_cast<uint32_t>(numbers.size());
        for (double number : numbers) {
            cdr << uint8_t{3} << false << int64_t{0} << number << std::string();
            for (int array = 0; array < 5; ++array) cdr << uint32_t{0};
        }
    }
    void get(Cdr&) { std::abort(); }  // it only answers
};

template <typename T>
class Support : public TopicDataType {
public:
    explicit Support(const char* name, T blank = T()) : blank_(blank) {
        setName(name);
        m_typeSize = 4096;
        m_isGetKeyDefined = false;
    }
    bool serialize(void* data, SerializedPayload_t* payload) override {
        FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->max_size);
        Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
        payload->encapsulation = cdr.endianness() == Cdr::BIG_ENDIANNESS ? CDR_BE : CDR_LE;
        cdr.serialize_encapsulation();
        static_cast<T*>(data)->put(cdr);
        payload->length = static_cast<uint32_t>(cdr.getSerializedDataLength());
        return true;
    }
    bool deserialize(SerializedPayload_t* payload, void* data) override {
        FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
        Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
        try {
            cdr.read_encapsulation();
            static_cast<T*>(data)->get(cdr);
        } catch (const eprosima::fastcdr::exception::Exception& error) {
            std::printf("damaged %s\n", error.what());
            return false;
        }
        return true;
    }
    std::function<uint32_t()> getSerializedSizeProvider(void*) override {
        return [this] { return m_typeSize; };
    }
    void* createData() override { return new T(blank_); }
    void deleteData(void* data) override { delete static_cast<T*>(data); }
    bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }

private:
    T blank_;
};

class Wheels : public DataReaderListener {
public:
    explicit Wheels(bool stamped) { blank_.stamped = stamped; }
    void on_subscription_matched(DataReader*, const SubscriptionMatchedStatus& status) override {
        std::printf("matched %d\n", status.current_count);
    }
    void on_data_available(DataReader* reader) override {
        Twist twist = blank_;
        SampleInfo info;
        while (reader->take_next_sample(&twist, &info) == ReturnCode_t::RETCODE_OK) {
            if (!info.valid_data) continue;
            auto now = std::chrono::steady_clock::now().time_since_epoch();
            long long now_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
            const double* six = twist.six;
            std::printf("twist %lld %lld %.17g %.17g %.17g %.17g\n", now_ns,
                        twist.header.sec * 1000000000LL + twist.header.nanosec, six[0], six[5], six[1],
                        std::fabs(six[2]) + std::fabs(six[3]) + std::fabs(six[4]));
        }
    }

private:
    Twist blank_;
};

// Answers for one parameter; for any other the answer is empty, as rclcpp's is.
class Node : public DataReaderListener {
public:
    Node(DomainParticipant* participant, const std::string& node, std::string name, double value)
        : name_(std::move(name)), value_(value) {
        TypeSupport asks(new Support<Asked>("rcl_interfaces::srv::dds_::GetParameters_Request_"));
        TypeSupport answers(new Support<Answered>("rcl_interfaces::srv::dds_::GetParameters_Response_"));
        asks.register_type(participant);
        answers.register_type(participant);
        auto* request = participant->create_topic("rq" + node + "/get_parametersRequest",
                                                  asks.get_type_name(), TOPIC_QOS_DEFAULT);
        auto* reply = participant->create_topic("rr" + node + "/get_parametersReply",
                                                answers.get_type_name(), TOPIC_QOS_DEFAULT);
        DataWriterQos writing = DATAWRITER_QOS_DEFAULT;
        writer_ = participant->create_publisher(PUBLISHER_QOS_DEFAULT)->create_datawriter(reply, writing);
        DataReaderQos reading = DATAREADER_QOS_DEFAULT;
        reading.reliability().kind = RELIABLE_RELIABILITY_QOS;
        participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT)->create_datareader(request, reading, this);
    }
    void on_data_available(DataReader* reader) override {
        Asked asked;
        SampleInfo info;
        while (reader->take_next_sample(&asked, &info) == ReturnCode_t::RETCODE_OK) {
            if (!info.valid_data) continue;
            Answered answered;
            for (const auto& name : asked.names) {
                if (name == name_) answered.numbers.push_back(value_);
            }
            eprosima::fastrtps::rtps::WriteParams whose;
            whose.related_sample_identity(info.sample_identity);
            writer_->write(&answered, whose);
        }
    }

private:
    std::string name_;
    double value_;
    DataWriter* writer_ = nullptr;
};

// Loopback only: nothing of a test leaves the machine.
DomainParticipantQos loopback(int domain) {
    DomainParticipantQos qos = PARTICIPANT_QOS_DEFAULT;
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.emplace_back("127.0.0.1");
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(udp);
    for (int index = 0; index < 10; ++index) {
        Locator_t peer;
        IPLocator::setIPv4(peer, 127, 0, 0, 1);
        peer.port = static_cast<uint32_t>(7400 + 250 * domain + 10 + 2 * index);
        qos.wire_protocol().builtin.initialPeersList.push_back(peer);
    }
    return qos;
}

}  // namespace

int main(int count, char** words) {
    if (count != 5) return 2;
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
    const int domain = std::atoi(words[1]);
    const std::string topic = words[2];
    const bool stamped = std::string(words[3]) == "stamped";
    auto* participant =
        DomainParticipantFactory::get_instance()->create_participant(domain, loopback(domain));
    if (participant == nullptr) return 1;
    const char* name = stamped ? "geometry_msgs::msg::dds_::TwistStamped_" : "geometry_msgs::msg::dds_::Twist_";
    Twist blank;
    blank.stamped = stamped;
    TypeSupport twist_type(new Support<Twist>(name, blank));
    TypeSupport odometry_type(new Support<Odometry>("nav_msgs::msg::dds_::Odometry_"));
    twist_type.register_type(participant);
    odometry_type.register_type(participant);

    auto* commands = participant->create_topic("rt" + topic, name, TOPIC_QOS_DEFAULT);
    DataReaderQos reading = DATAREADER_QOS_DEFAULT;
    reading.reliability().kind = std::string(words[4]) == "reliable" ? RELIABLE_RELIABILITY_QOS
                                                                    : BEST_EFFORT_RELIABILITY_QOS;
    reading.history().kind = KEEP_LAST_HISTORY_QOS;
    reading.history().depth = 10;
    Wheels wheels(stamped);
    participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT)->create_datareader(commands, reading, &wheels);

    auto* told = participant->create_topic("rt/odom", odometry_type.get_type_name(), TOPIC_QOS_DEFAULT);
    DataWriterQos writing = DATAWRITER_QOS_DEFAULT;
    writing.history().kind = KEEP_LAST_HISTORY_QOS;
    writing.history().depth = 10;
    auto* odometry = participant->create_publisher(PUBLISHER_QOS_DEFAULT)->create_datawriter(told, writing);
    std::printf("ready\n");
    std::vector<std::unique_ptr<Node>> nodes;

    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream in(line);
        std::string what;
        if (line.rfind("parameter ", 0) == 0) {
            std::string node, name;
            double value = 0;
            in >> what >> node >> name >> value;
            nodes.push_back(std::make_unique<Node>(participant, node, name, value));
            continue;
        }
        Odometry said;
        in >> what >> said.pose[0] >> said.pose[1] >> said.pose[5] >> said.pose[6] >> said.twist[0] >>
            said.twist[5];
        if (what == "odometry" && in) odometry->write(&said);
    }
    participant->delete_contained_entities();
    DomainParticipantFactory::get_instance()->delete_participant(participant);
    return 0;
}
